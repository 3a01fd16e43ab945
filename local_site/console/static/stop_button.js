// The stop: button or Esc, always; repeated until the remote site acknowledges it, with an alarm while it has not.
/** @import { Answer, Situation } from "../model/messages.d.ts" */
/** @import { Alert } from "./alert.js" */
/** @import { Connection } from "./connection.js" */
import { tagged } from "./elements.js";
import { EMERGENCY } from "./emergency.js";
const AGAIN_MS = 1000;
const PATIENT_MS = 500; // without an acknowledgement by then something is wrong

export class StopButton {
  #connection;
  #letGo;
  #alert;
  /** @type {number | null} */
  #pressedMs = null;
  /** @type {Set<number>} */
  #asked = new Set();
  #askedMs = 0;
  #why = "";
  #stopped = false;
  #isDown = false;

  /** @param {Connection} connection @param {Alert} alert @param {() => void} letGo */
  constructor(connection, alert, letGo) {
    this.#connection = connection;
    this.#alert = alert;
    this.#letGo = letGo;
    const button = tagged("button", "stop");
    button.addEventListener("pointerdown", () => this.#stop());
    button.addEventListener("click", (event) => event.detail === 0 && this.#stop());
    addEventListener("keydown", (event) => this.#key(event), { capture: true });
    addEventListener("keyup", ({ key }) => (this.#isDown &&= key !== "Escape"), { capture: true });
    addEventListener("blur", () => (this.#isDown = false));
  }

  /** An answer of the console, to a stop or to something else.
   * @type {(answer: Answer) => void} */
  onReply({ id, what, done, reason }) {
    if (what !== "stop" || !this.#asked.delete(id) || this.#pressedMs === null) return;
    this.#why = done ? "" : reason.replace(/[.?!]$/, "");
    if (done) {
      this.#alert.show("stop", "good", `Stop acknowledged by the remote site after ${Math.round(performance.now() - this.#pressedMs)} ms`);
      this.#pressedMs = null;
      this.#asked.clear();
    }
    this.refresh();
  }

  /** Repeat a stop that was not acknowledged, and show that. */
  refresh() {
    if (this.#pressedMs === null) return;
    if (performance.now() - this.#askedMs > AGAIN_MS) this.#send();
    if (performance.now() - this.#pressedMs < PATIENT_MS && this.#why === "") return;
    const why = this.#why || "no answer yet";
    this.#alert.show("stop", "bad", `STOP NOT ACKNOWLEDGED: ${why}. If the arm moves, ${EMERGENCY}. The stop is repeated until it is acknowledged.`);
  }

  /** Once the stop is reset, its acknowledgement has been read.
   * @type {(situation: Situation) => void} */
  show({ robot }) {
    const stopped = robot?.readiness.code === "stopped";
    if (this.#stopped && !stopped) this.#alert.clear("stop", "good");
    this.#stopped = stopped;
  }

  /** Remove an acknowledgement that is outdated. */
  disconnected() {
    this.#alert.clear("stop", "good");
  }

  /** @type {(event: KeyboardEvent) => void} */
  #key(event) {
    if (event.key !== "Escape") return;
    event.preventDefault();
    if (!event.repeat || !this.#isDown) this.#stop(); // it may have gone down before the page had the keyboard
    this.#isDown = true;
  }

  #stop() {
    if (document.body.hasAttribute("data-replay")) {
      this.#alert.show("stop", "bad", "This is a replay, no robot is connected to it: stop a real one on its own page, or by the emergency stop at the robot");
      return;
    }
    this.#letGo();
    this.#pressedMs = performance.now();
    this.#asked.clear();
    this.#why = "";
    this.#alert.show("stop", "bad", "Stop sent, not acknowledged yet");
    this.#send();
    this.refresh();
  }

  #send() {
    this.#askedMs = performance.now();
    const id = this.#connection.ask({ type: "ask", action: "stop" });
    if (id === null) this.#why = "not sent, there is no connection to the console";
    else this.#asked.add(id);
  }
}

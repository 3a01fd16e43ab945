// The stop: button or Esc, always; it tells whether the remote site has acknowledged it.
export class StopButton {
  #connection;
  #letGo;
  #alert = document.getElementById("alert");
  #asked = new Map();
  #stopped = false;

  constructor(connection, letGo) {
    this.#connection = connection;
    this.#letGo = letGo;
    const button = document.getElementById("stop");
    button.addEventListener("pointerdown", () => this.#stop());
    button.addEventListener("click", (event) => event.detail === 0 && this.#stop());
    addEventListener("keydown", (event) => this.#key(event), { capture: true });
  }

  /** An answer of the console, to a stop or to something else. */
  hear({ id, what, done, reason }) {
    if (what !== "stop" || !this.#asked.has(id)) return;
    const took = Math.round(performance.now() - this.#asked.get(id));
    this.#asked.delete(id);
    if (done) this.#say("good", `Stop acknowledged by the remote site after ${took} ms`);
    else this.#say("bad", `STOP NOT ACKNOWLEDGED: ${reason}. Use the emergency stop.`);
  }

  #key(event) {
    if (event.key !== "Escape") return;
    event.preventDefault();
    if (!event.repeat) this.#stop();
  }

  #stop() {
    this.#letGo();
    const id = this.#connection.ask({ type: "ask", action: "stop" });
    if (id === null) {
      this.#say("bad", "STOP NOT SENT: there is no connection to the console. Use the emergency stop.");
      return;
    }
    this.#asked.set(id, performance.now());
    this.#say("bad", "Stop sent, not acknowledged yet");
  }

  /** Once the stop is reset, its acknowledgement has been read. */
  show({ robot }) {
    const stopped = robot?.readiness.code === "stopped";
    if (this.#stopped && !stopped) this.#alert.hidden = true;
    this.#stopped = stopped;
  }

  #say(kind, words) {
    this.#alert.hidden = false;
    this.#alert.dataset.kind = kind;
    this.#alert.textContent = words;
  }
}

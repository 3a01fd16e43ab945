// The bar of a replay: play, pause, speed, a timeline with a mark for each event, and the list of them to jump to; and the mark that nothing here is live.
/** @import { Hello, Replay, ReplayedEvent } from "../model/messages.d.ts" */
/** @import { Alert } from "./alert.js" */
/** @import { Connection } from "./connection.js" */
import { element, tagged } from "./elements.js";
import { put } from "./words.js";

const MOVED_MS = 400; // after the slider's last change
const STEP_S = 5;

export class ReplayBar {
  #connection;
  #alert;
  #onJump;
  #running = false;
  #position = 0;
  #duration = 0;
  /** @type {number | null} */
  #jumps = null;
  #movedMs = -Infinity;

  /** @param {Connection} connection @param {Alert} alert @param {() => void} onJump */
  constructor(connection, alert, onJump) {
    this.#connection = connection;
    this.#alert = alert;
    this.#onJump = onJump;
    element("play").addEventListener("click", () => this.#toggle());
    element("speed").addEventListener("change", () => this.#send({ speed: Number(tagged("select", "speed").value) }));
    element("timeline").addEventListener("input", () => this.#drag());
    addEventListener("keydown", (event) => this.#key(event), { capture: true }); // before the key that is held on a live page
  }

  /** Whether the page shows a recording. */
  get isShown() {
    return !element("replay").hidden;
  }

  /** `replay` describes the recording; null on a live page.
   * @type {(message: Hello) => void} */
  hello({ replay }) {
    element("replay").hidden = element("replay-mark").hidden = replay === null;
    document.body.toggleAttribute("data-replay", replay !== null);
    if (replay === null) return;
    document.title = `REPLAY ${replay.name}`;
    put(element("replay-name"), `${replay.name}, recorded ${replay.began}`);
    this.#duration = replay.duration_s;
    tagged("input", "timeline").max = String(replay.duration_s);
    element("ticks").replaceChildren(...replay.events.map((event) => tickAt(event, replay.duration_s)));
    element("jumps").replaceChildren(...replay.events.map((event) => this.#jumpTo(event)));
  }

  /** @type {(message: Replay) => void} */
  show({ running, position_s: position, speed, jumps, trouble }) {
    if (trouble) this.#alert.show("replay", "bad", trouble);
    else this.#alert.clear("replay");
    this.#running = running;
    this.#position = position;
    put(element("play-word"), running ? "Pause" : "Play");
    put(element("position"), `${tenthsWords(position)} / ${tenthsWords(this.#duration)}`);
    if (performance.now() - this.#movedMs > MOVED_MS) tagged("input", "timeline").value = String(position);
    element("timeline").setAttribute("aria-valuetext", tenthsWords(position));
    if (document.activeElement !== element("speed")) tagged("select", "speed").value = String(speed);
    if (jumps !== this.#jumps) this.#onJump();
    this.#jumps = jumps;
  }

  /** @type {(event: ReplayedEvent) => HTMLElement} */
  #jumpTo(event) {
    const [item, button] = [document.createElement("li"), document.createElement("button")];
    button.type = "button";
    button.dataset.kind = event.kind;
    button.textContent = `${tenthsWords(event.at_s)} ${event.words}`;
    button.addEventListener("click", () => {
      this.#send({ position_s: event.at_s });
      tagged("details", "jump-list").open = false;
    });
    item.append(button);
    return item;
  }

  #toggle() {
    this.#send({ playing: !this.#running });
  }

  #drag() {
    this.#movedMs = performance.now();
    this.#send({ position_s: Number(tagged("input", "timeline").value) });
  }

  /** @type {(event: KeyboardEvent) => void} */
  #key(event) {
    if (!this.isShown || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.code === "Space" && !event.repeat) this.#toggle();
    if (event.target instanceof HTMLSelectElement) return;
    /** @type {Record<string, number>} */
    const steps = { ArrowLeft: -STEP_S, ArrowRight: STEP_S };
    if (!(event.key in steps)) return;
    event.preventDefault();
    this.#send({ position_s: Math.max(0, this.#position + steps[event.key]) });
  }

  /** @type {(how: { playing?: boolean, speed?: number, position_s?: number }) => void} */
  #send(how) {
    this.#connection.send({ type: "play", ...how });
  }
}

/** A mark on the timeline where something happened.
 * @type {(event: ReplayedEvent, duration: number) => HTMLElement} */
function tickAt({ at_s: at, kind, words }, duration) {
  const tick = document.createElement("span");
  tick.dataset.kind = kind;
  tick.title = words;
  tick.style.setProperty("--at", String(duration > 0 ? Math.min(1, Math.max(0, at / duration)) : 0));
  return tick;
}

/** Minutes, seconds and tenths, as on a clock.
 * @type {(seconds: number) => string} */
function tenthsWords(seconds) {
  const tenths = Math.floor(seconds * 10);
  const [minutes, rest] = [Math.floor(tenths / 600), tenths % 600];
  return `${minutes}:${String(Math.floor(rest / 10)).padStart(2, "0")}.${rest % 10}`;
}

// The bar of a replay: play, pause, speed, a timeline with a mark for each event, and the list of them to jump to; and the mark that nothing here is live.
import { put } from "./words.js";

const MOVED_MS = 400; // after the slider's last change
const STEP_S = 5;
const element = (id) => document.getElementById(id);

export class ReplayBar {
  #connection;
  #alert;
  #onJump;
  #running = false;
  #position = 0;
  #duration = 0;
  #jumps = null;
  #movedMs = -Infinity;

  constructor(connection, alert, onJump) {
    this.#connection = connection;
    this.#alert = alert;
    this.#onJump = onJump;
    element("play").addEventListener("click", () => this.#toggle());
    element("speed").addEventListener("change", () => this.#send({ speed: Number(element("speed").value) }));
    element("timeline").addEventListener("input", () => this.#drag());
    addEventListener("keydown", (event) => this.#key(event), { capture: true }); // before the key that is held on a live page
  }

  /** Whether the page shows a recording. */
  get isShown() {
    return !element("replay").hidden;
  }

  /** `replay` describes the recording; null on a live page. */
  hello({ replay }) {
    element("replay").hidden = element("replay-mark").hidden = replay === null;
    document.body.toggleAttribute("data-replay", replay !== null);
    if (replay === null) return;
    document.title = `REPLAY ${replay.name}`;
    put(element("replay-name"), `${replay.name}, recorded ${replay.began}`);
    this.#duration = replay.duration_s;
    element("timeline").max = replay.duration_s;
    element("ticks").replaceChildren(...replay.events.map((event) => tickAt(event, replay.duration_s)));
    element("jumps").replaceChildren(...replay.events.map((event) => this.#jumpTo(event)));
  }

  show({ running, position_s: position, speed, jumps, trouble }) {
    if (trouble) this.#alert.show("replay", "bad", trouble);
    else this.#alert.clear("replay");
    this.#running = running;
    this.#position = position;
    put(element("play-word"), running ? "Pause" : "Play");
    put(element("position"), `${tenthsWords(position)} / ${tenthsWords(this.#duration)}`);
    if (performance.now() - this.#movedMs > MOVED_MS) element("timeline").value = position;
    element("timeline").setAttribute("aria-valuetext", tenthsWords(position));
    if (document.activeElement !== element("speed")) element("speed").value = String(speed);
    if (jumps !== this.#jumps) this.#onJump();
    this.#jumps = jumps;
  }

  #jumpTo(event) {
    const [item, button] = [document.createElement("li"), document.createElement("button")];
    button.type = "button";
    button.dataset.kind = event.kind;
    button.textContent = `${tenthsWords(event.at_s)} ${event.words}`;
    button.addEventListener("click", () => {
      this.#send({ position_s: event.at_s });
      element("jump-list").open = false;
    });
    item.append(button);
    return item;
  }

  #toggle() {
    this.#send({ playing: !this.#running });
  }

  #drag() {
    this.#movedMs = performance.now();
    this.#send({ position_s: Number(element("timeline").value) });
  }

  #key(event) {
    if (!this.isShown || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.code === "Space" && !event.repeat) this.#toggle();
    if (event.target.tagName === "SELECT") return;
    const steps = { ArrowLeft: -STEP_S, ArrowRight: STEP_S };
    if (!(event.key in steps)) return;
    event.preventDefault();
    this.#send({ position_s: Math.max(0, this.#position + steps[event.key]) });
  }

  #send(how) {
    this.#connection.send({ type: "play", ...how });
  }
}

/** A mark on the timeline where something happened. */
function tickAt({ at_s: at, kind, words }, duration) {
  const tick = document.createElement("span");
  tick.dataset.kind = kind;
  tick.title = words;
  tick.style.setProperty("--at", duration > 0 ? Math.min(1, Math.max(0, at / duration)) : 0);
  return tick;
}

/** Minutes, seconds and tenths, as on a clock. */
function tenthsWords(seconds) {
  const tenths = Math.floor(seconds * 10);
  const [minutes, rest] = [Math.floor(tenths / 600), tenths % 600];
  return `${minutes}:${String(Math.floor(rest / 10)).padStart(2, "0")}.${rest % 10}`;
}

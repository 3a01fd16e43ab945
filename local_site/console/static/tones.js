// Tones for what the arm does, for an operator who looks at the pictures: M turns them off, which is remembered.
import { pressByKey } from "./keys.js";

const KEY = "farhand-tones";
const NOTE_S = 0.11;
const LOUD = 0.12;
const NOTES = {
  engaged: [523, 784],
  holding: [392],
  fault: [440, 330, 220],
  stopped: [440, 330, 220],
  silent: [440, 220],
  lost: [440, 220],
};
const SAME = { limited: "engaged", behind: "engaged", led: "engaged" }; // still under way: no tone of their own

export class Tones {
  #button = document.getElementById("tones");
  #audio = null;
  #on = localStorage.getItem(KEY) !== "off";
  #last = null;

  constructor() {
    this.#button.addEventListener("click", () => this.#toggle());
    pressByKey({ m: this.#button });
    addEventListener("keydown", () => this.#wake());
    addEventListener("pointerdown", () => this.#wake(), { capture: true });
    this.#describe();
  }

  /** Play what belongs to a condition, unless it sounds like the one before. */
  play(name) {
    const heard = SAME[name] ?? name;
    const isNew = this.#last !== null && heard !== this.#last;
    this.#last = heard;
    if (this.#on && isNew && this.#audio !== null && heard in NOTES) this.#sound(NOTES[heard]);
  }

  /** Browsers let a page sound only after its user has done something. */
  #wake() {
    if (this.#on) this.#audio ??= new AudioContext();
  }

  #toggle() {
    this.#on = !this.#on;
    localStorage.setItem(KEY, this.#on ? "on" : "off");
    this.#wake();
    this.#describe();
  }

  #describe() {
    this.#button.setAttribute("aria-pressed", this.#on);
  }

  #sound(notes) {
    const begin = this.#audio.currentTime;
    notes.forEach((hz, k) => {
      const [note, gain] = [this.#audio.createOscillator(), this.#audio.createGain()];
      const at = begin + k * NOTE_S;
      note.frequency.value = hz;
      gain.gain.setValueAtTime(LOUD, at);
      gain.gain.exponentialRampToValueAtTime(0.001, at + 1.5 * NOTE_S);
      note.connect(gain).connect(this.#audio.destination);
      note.start(at);
      note.stop(at + 1.5 * NOTE_S);
    });
  }
}

// Tones for what the arm does, for an operator who looks at the pictures: M turns them off, which is remembered.
import { tagged } from "./elements.js";
import { pressByKey } from "./keys.js";

const KEY = "farhand-tones";
const NOTE_S = 0.11;
const LOUD = 0.12;
/** @type {Record<string, number[]>} */
const NOTES = {
  engaged: [523, 784],
  holding: [392],
  fault: [440, 330, 220],
  stopped: [440, 330, 220],
  silent: [440, 220],
  lost: [440, 220],
};
/** @type {Record<string, string>} */
const SAME = { limited: "engaged", behind: "engaged", led: "engaged" }; // still under way: no tone of their own

export class Tones {
  #button = tagged("button", "tones");
  /** @type {AudioContext | null} */
  #audio = null;
  #on = localStorage.getItem(KEY) !== "off";
  /** @type {string | null} */
  #last = null;

  constructor() {
    this.#button.addEventListener("click", () => this.#toggle());
    pressByKey({ m: this.#button });
    addEventListener("keydown", () => this.#wake());
    addEventListener("pointerdown", () => this.#wake(), { capture: true });
    this.#describe();
  }

  /** Play what belongs to a condition, unless it sounds like the one before.
   * @type {(name: string) => void} */
  play(name) {
    const heard = SAME[name] ?? name;
    const isNew = this.#last !== null && heard !== this.#last;
    this.#last = heard;
    if (this.#on && isNew && this.#audio !== null && heard in NOTES) this.#sound(this.#audio, NOTES[heard]);
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
    this.#button.setAttribute("aria-pressed", String(this.#on));
  }

  /** @type {(audio: AudioContext, notes: number[]) => void} */
  #sound(audio, notes) {
    const begin = audio.currentTime;
    notes.forEach((hz, k) => {
      const [note, gain] = [audio.createOscillator(), audio.createGain()];
      const at = begin + k * NOTE_S;
      note.frequency.value = hz;
      gain.gain.setValueAtTime(LOUD, at);
      gain.gain.exponentialRampToValueAtTime(0.001, at + 1.5 * NOTE_S);
      note.connect(gain).connect(audio.destination);
      note.start(at);
      note.stop(at + 1.5 * NOTE_S);
    });
  }
}

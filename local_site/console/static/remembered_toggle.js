// A button that is on or off, pressed by a key as well, and as the browser remembers it.
import { tagged } from "./elements.js";
import { pressByKey } from "./keys.js";

export class RememberedToggle {
  isOn = false;
  #button;
  #name;
  #changed;

  /** The button of this `id` is `isOn` until it is pressed; `changed` is called whenever it is, and once now.
   * @param {string} id @param {string} key @param {boolean} isOn @param {(isOn: boolean) => void} changed */
  constructor(id, key, isOn, changed) {
    this.#button = tagged("button", id);
    this.#name = `farhand-${id}`;
    this.#changed = changed;
    this.#button.addEventListener("click", () => this.#set(!this.isOn));
    pressByKey({ [key]: this.#button });
    this.#set((localStorage.getItem(this.#name) ?? (isOn ? "on" : "off")) === "on");
  }

  /** Whether there is anything to switch.
   * @type {(isOffered: boolean) => void} */
  offer(isOffered) {
    this.#button.hidden = !isOffered;
  }

  /** @type {(isOn: boolean) => void} */
  #set(isOn) {
    this.isOn = isOn;
    localStorage.setItem(this.#name, isOn ? "on" : "off");
    this.#button.setAttribute("aria-pressed", String(isOn));
    this.#changed(isOn);
  }
}

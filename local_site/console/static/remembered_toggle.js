// A button that is on or off, pressed by a key as well, and as the browser remembers it.
import { pressByKey } from "./keys.js";

export class RememberedToggle {
  isOn;
  #button;
  #name;
  #changed;

  /** The button of this `id` is `isOn` until it is pressed; `changed` is called whenever it is, and once now. */
  constructor(id, key, isOn, changed) {
    this.#button = document.getElementById(id);
    this.#name = `farhand-${id}`;
    this.#changed = changed;
    this.#button.addEventListener("click", () => this.#set(!this.isOn));
    pressByKey({ [key]: this.#button });
    this.#set((localStorage.getItem(this.#name) ?? (isOn ? "on" : "off")) === "on");
  }

  /** Whether there is anything to switch. */
  offer(isOffered) {
    this.#button.hidden = !isOffered;
  }

  #set(isOn) {
    this.isOn = isOn;
    localStorage.setItem(this.#name, isOn ? "on" : "off");
    this.#button.setAttribute("aria-pressed", isOn);
    this.#changed(isOn);
  }
}

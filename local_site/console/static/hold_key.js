// A key that is held, or a pedal that types it, or its button: hold to run, assist and clutch; a hidden page releases it unseen.
import { canPress } from "./keys.js";

export class HoldKey {
  down = false;
  /** Whether it is up because the page could not see it any more: nobody knows whether it was let go. */
  isUnseen = false;
  #button;
  #code;
  #changed;

  /** `code` is that of a KeyboardEvent; `changed` is called whenever the key goes down or up.
   * @param {HTMLButtonElement} button @param {string} code @param {() => void} changed */
  constructor(button, code, changed) {
    this.#button = button;
    this.#code = code;
    this.#changed = changed;
    addEventListener("keydown", (event) => this.#key(event, true), { capture: true });
    addEventListener("keyup", (event) => this.#key(event, false), { capture: true });
    this.#button.addEventListener("pointerdown", (event) => {
      this.#button.setPointerCapture(event.pointerId);
      this.#set(true);
    });
    this.#button.addEventListener("pointerup", () => this.#set(false));
    for (const end of ["pointercancel", "lostpointercapture", "contextmenu"]) this.#button.addEventListener(end, () => this.release());
    for (const end of ["blur", "pagehide", "freeze"]) addEventListener(end, () => this.release());
    document.addEventListener("visibilitychange", () => this.release());
  }

  /** Count it as up without having seen it. */
  release() {
    this.#set(false, true);
  }

  /** @type {(event: KeyboardEvent, down: boolean) => void} */
  #key(event, down) {
    if (event.code !== this.#code) return;
    if (down && (event.ctrlKey || event.altKey || event.metaKey)) return;
    event.preventDefault();
    event.stopPropagation();
    if (!event.repeat && (!down || canPress(this.#button))) this.#set(down);
  }

  /** @type {(down: boolean, isUnseen?: boolean) => void} */
  #set(down, isUnseen = false) {
    if (this.down === down) return;
    this.down = down;
    this.isUnseen = isUnseen;
    this.#button.setAttribute("aria-pressed", String(down));
    this.#changed();
  }
}

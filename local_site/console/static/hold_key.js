// A key that is held, or a pedal that types it, or its button: hold to run, and the assist; a hidden page releases it.
import { canPress } from "./keys.js";

export class HoldKey {
  down = false;
  #button;
  #code;
  #changed;

  /** `code` is that of a KeyboardEvent; `changed` is called whenever the key goes down or up. */
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
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "contextmenu"]) {
      this.#button.addEventListener(end, () => this.release());
    }
    for (const end of ["blur", "pagehide", "freeze"]) addEventListener(end, () => this.release());
    document.addEventListener("visibilitychange", () => this.release());
  }

  release() {
    this.#set(false);
  }

  #key(event, down) {
    if (event.code !== this.#code) return;
    if (down && (event.ctrlKey || event.altKey || event.metaKey)) return;
    event.preventDefault();
    event.stopPropagation();
    if (!event.repeat && (!down || canPress(this.#button))) this.#set(down);
  }

  #set(down) {
    if (this.down === down) return;
    this.down = down;
    this.#button.setAttribute("aria-pressed", down);
    this.#changed();
  }
}

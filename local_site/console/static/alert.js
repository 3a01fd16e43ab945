// The alarm line under the state: a stop that is not acknowledged has priority over everything else.
import { element } from "./elements.js";

/** @typedef {"good" | "bad"} Kind */

export class Alert {
  #line = element("alert");
  /** @type {string | null} */
  #owner = null;

  /** Show an owner's message; kind is good or bad.
   * @type {(owner: string, kind: Kind, words: string) => void} */
  show(owner, kind, words) {
    if (this.#owner === "stop" && owner !== "stop" && this.#line.dataset.kind === "bad") return;
    this.#owner = owner;
    this.#line.hidden = false;
    this.#line.dataset.kind = kind;
    this.#line.textContent = words;
  }

  /** Remove an owner's message, of any kind or of one.
   * @type {(owner: string, kind?: string) => void} */
  clear(owner, kind = this.#line.dataset.kind) {
    if (this.#owner !== owner || this.#line.dataset.kind !== kind) return;
    this.#owner = null;
    this.#line.hidden = true;
  }
}

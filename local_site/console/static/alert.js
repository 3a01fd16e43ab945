// The alarm line under the state: a stop that is not acknowledged has priority over everything else.
export class Alert {
  #line = document.getElementById("alert");
  #owner = null;

  /** Say something in somebody's name; kind is good or bad. */
  say(owner, kind, words) {
    if (this.#owner === "stop" && owner !== "stop" && this.#line.dataset.kind === "bad") return;
    this.#owner = owner;
    this.#line.hidden = false;
    this.#line.dataset.kind = kind;
    this.#line.textContent = words;
  }

  /** Take back what was said in somebody's name, all of it or one kind. */
  clear(owner, kind = this.#line.dataset.kind) {
    if (this.#owner !== owner || this.#line.dataset.kind !== kind) return;
    this.#owner = null;
    this.#line.hidden = true;
  }
}

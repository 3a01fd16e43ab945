// The newest halt (stop, fault, end of an engagement) that the page shows, and the newest that can have been read; pure.
const READ_MS = 500; // nobody reads who has stopped the arm, and decides, in less

export class ShownHalts {
  #newest = "0";
  #before = "0";
  #sinceMs = -Infinity;

  /** The state that is shown from a time in ms has this newest halt.
   * @type {(halt: string, nowMs: number) => void} */
  show(halt, nowMs) {
    if (halt === this.#newest) return;
    this.#before = this.readBy(nowMs);
    this.#newest = halt;
    this.#sinceMs = nowMs;
  }

  get newest() {
    return this.#newest;
  }

  /** The newest that has been shown for long enough at a time in ms.
   * @type {(nowMs: number) => string} */
  readBy(nowMs) {
    return nowMs - this.#sinceMs < READ_MS ? this.#before : this.#newest;
  }
}

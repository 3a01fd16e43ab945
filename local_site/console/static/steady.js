// A condition without flicker: a worse one shows at once, a better one when it has lasted, and the first cause stays.
/** @import { Condition } from "./condition.js" */

const CALM_MS = 600;
/** @type {Record<string, number>} */
const RANKS = { engaged: 0, limited: 1, behind: 1, led: 1, holding: 2 };
const CAUSES = ["fault", "stopped"];

export class Steady {
  /** @type {Condition | null} */
  #shown = null;
  /** @type {number | null} */
  #betterMs = null;
  /** @type {Condition | null} */
  #cause = null;

  /** The condition to show for the newest one at a time in ms.
   * @type {(condition: Condition, nowMs: number) => Condition} */
  show(condition, nowMs) {
    const answered = this.#withCause(condition);
    if (this.#shown !== null && this.#isBetter(answered, this.#shown)) {
      this.#betterMs ??= nowMs;
      if (nowMs - this.#betterMs < CALM_MS) return this.#shown;
    }
    this.#betterMs = null;
    this.#shown = answered;
    return answered;
  }

  /** @type {(condition: Condition, shown: Condition) => boolean} */
  #isBetter({ name }, shown) {
    return RANKS[name] < RANKS[shown.name];
  }

  /** What stopped the arm stays until it is answered, though the site falls silent afterwards.
   * @type {(condition: Condition) => Condition} */
  #withCause(condition) {
    if (CAUSES.includes(condition.name)) this.#cause = condition;
    else if (!["silent", "lost"].includes(condition.name)) this.#cause = null;
    if (this.#cause === null || this.#cause === condition) return condition;
    return { ...condition, word: this.#cause.word, sentence: `${this.#cause.sentence} · then: ${condition.sentence}` };
  }
}

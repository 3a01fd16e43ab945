// A condition without flicker: a worse one shows at once, a better one when it has lasted, and the first cause stays.
const CALM_MS = 600;
const RANKS = { engaged: 0, limited: 1, behind: 1, led: 1, holding: 2 };
const CAUSES = ["fault", "stopped"];

export class Steady {
  #shown = null;
  #betterMs = null;
  #cause = null;

  /** The condition to show for the newest one at a time in ms. */
  show(condition, nowMs) {
    const answered = this.#withCause(condition);
    if (this.#isBetter(answered)) {
      this.#betterMs ??= nowMs;
      if (nowMs - this.#betterMs < CALM_MS) return this.#shown;
    }
    this.#betterMs = null;
    this.#shown = answered;
    return answered;
  }

  #isBetter({ name }) {
    return RANKS[name] < RANKS[this.#shown?.name];
  }

  /** What stopped the arm stays until it is answered, though the site falls silent afterwards. */
  #withCause(condition) {
    if (CAUSES.includes(condition.name)) this.#cause = condition;
    else if (!["silent", "lost"].includes(condition.name)) this.#cause = null;
    if (this.#cause === null || this.#cause === condition) return condition;
    return { ...condition, word: this.#cause.word, sentence: `${this.#cause.sentence} · then: ${condition.sentence}` };
  }
}

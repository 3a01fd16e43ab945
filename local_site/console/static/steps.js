// The operator's buttons: the one that comes next is large, what else is possible small, the rest is not there.
/** @import { Cell, Situation, ToolPoses } from "../model/messages.d.ts" */
/** @import { Condition } from "./condition.js" */
/** @import { PageFacts, Step } from "./next_step.js" */
import { element } from "./elements.js";
import { lostWords, stepOf } from "./next_step.js";
import { WayBack } from "./way_back.js";
import { mark, put } from "./words.js";

const NAMES = ["seat-button", "lease-button", "hold", "engage", "disengage", "reset", "clutch", "origins"];
const LONG = 60; // letters: more are written smaller where they have a button's place

export class Steps {
  #words = element("step-words");
  #buttons = NAMES.map((name) => element(name));
  #held = false;
  #wayBack = new WayBack();

  /** @type {(cell: Cell) => void} */
  describe({ held }) {
    this.#held = held;
  }

  /** @type {(condition: Condition, situation: Situation, facts: Omit<PageFacts, "held" | "back"> & { tools: ToolPoses }) => void} */
  show(condition, situation, { tools, ...controls }) {
    this.#set(stepOf(condition, situation, { ...controls, held: this.#held, back: this.#wayBack.words(tools) }));
  }

  disconnected() {
    this.#set({ next: null, minor: [], words: lostWords });
  }

  /** @type {(step: Step) => void} */
  #set({ next, waits = false, minor, words }) {
    put(this.#words, words);
    mark(this.#words, "data-long", words.length > LONG);
    for (const button of this.#buttons) {
      const rank = button.id === next ? "next" : minor.includes(button.id) ? "minor" : "absent";
      mark(button, "data-rank", rank);
      mark(button, "data-waits", waits && rank === "next");
    }
  }
}

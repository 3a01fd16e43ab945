// The operator's buttons: the one that comes next is large, what else is possible small, the rest is not there.
import { stepOf } from "./next_step.js";
import { mark, put } from "./words.js";

const NAMES = ["seat-button", "lease-button", "hold", "engage", "disengage", "reset", "clutch", "origins"];
const LONG = 60; // letters: more are written smaller where they have a button's place

export class Steps {
  #words = document.getElementById("step-words");
  #buttons = NAMES.map((name) => document.getElementById(name));
  #held = false;

  describe({ held }) {
    this.#held = held;
  }

  show(condition, situation, controls) {
    this.#set(stepOf(condition, situation, { ...controls, held: this.#held }));
  }

  disconnected() {
    this.#set({ next: null, minor: [], words: "Nothing can be done from here until the console answers." });
  }

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

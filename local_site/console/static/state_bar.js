// The bar over everything: what the arm does, in one colour that is read from two metres, and why.
import { conditionOf, lostCondition, saidOf } from "./condition.js";
import { Steady } from "./steady.js";
import { READ_MS, mark, put } from "./words.js";

const SILENT_MS = 500;

export class StateBar {
  #state = document.getElementById("state");
  #word = document.getElementById("state-word");
  #second = document.getElementById("state-second");
  #reason = document.getElementById("reason");
  #cell = document.getElementById("cell");
  #steady = new Steady();
  #receivedMs = null;
  #saidMs = -Infinity;
  #connected = false;
  #said = saidOf(false);
  #whose = { page: null, operator: "", remote: "" };
  #changed;

  /** `changed` is called with each other condition that is shown. */
  constructor(changed) {
    this.#changed = changed;
  }

  hello({ replay, page, operator, remote }) {
    this.#said = saidOf(replay !== null);
    this.#whose = { page, operator, remote };
  }

  describe({ cell, robot, driver }) {
    this.#cell.textContent = `${cell} · ${robot.split("/").at(-1).replace(/\.urdf$/, "")} · ${driver}`;
  }

  disconnected() {
    this.#connected = false;
    return this.#show(lostCondition(this.#said));
  }

  /** Whether the console has fallen silent with its connection open. */
  get isSilent() {
    return this.#connected && performance.now() - this.#receivedMs > SILENT_MS;
  }

  /** Show the newest state; the condition that is shown for it. */
  show(situation) {
    this.#connected = true;
    this.#receivedMs = performance.now();
    return this.#show(conditionOf(situation, this.#whose, this.#said));
  }

  #show(newest) {
    const condition = this.#steady.show(newest, performance.now());
    const isSame = this.#state.dataset.state === condition.name;
    if (isSame && performance.now() - this.#saidMs < READ_MS) return condition; // figures in it change all the time
    this.#saidMs = performance.now();
    if (!isSame) this.#changed(condition.name);
    mark(this.#state, "data-state", condition.name);
    mark(document.body, "data-tone", condition.tone);
    put(this.#word, condition.word);
    put(this.#second, condition.second ?? "");
    put(this.#reason, condition.sentence);
    mark(this.#reason, "title", condition.sentence); // two lines may not hold it all
    return condition;
  }
}

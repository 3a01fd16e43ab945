// The bar over everything: what the arm does, in one colour that is read from two metres, and why.
/** @import { Cell, Hello, Situation } from "../model/messages.d.ts" */
/** @import { Condition } from "./condition.js" */
/** @import { Whose } from "./halt_words.js" */
import { conditionOf, lostCondition, saidOf } from "./condition.js";
import { element } from "./elements.js";
import { Steady } from "./steady.js";
import { mark, put } from "./words.js";

const SILENT_MS = 500;

export class StateBar {
  #state = element("state");
  #word = element("state-word");
  #second = element("state-second");
  #reason = element("reason");
  #cell = element("cell");
  #steady = new Steady();
  #receivedMs = 0;
  #connected = false;
  #said = saidOf(false);
  /** @type {Whose} */
  #whose = { page: null, operator: "", remote: "" };
  #changed;

  /** `changed` is called with each other condition that is shown.
   * @param {(name: string) => void} changed */
  constructor(changed) {
    this.#changed = changed;
  }

  /** @type {(message: Hello) => void} */
  hello({ replay, page, operator, remote }) {
    this.#said = saidOf(replay !== null);
    this.#whose = { page, operator, remote };
  }

  /** @type {(description: Cell) => void} */
  describe({ cell, robot, driver }) {
    this.#cell.textContent = `${cell} · ${robot.slice(robot.lastIndexOf("/") + 1).replace(/\.urdf$/, "")} · ${driver}`;
  }

  disconnected() {
    this.#connected = false;
    return this.#show(lostCondition(this.#said), true);
  }

  /** Whether the console has fallen silent with its connection open. */
  get isSilent() {
    return this.#connected && performance.now() - this.#receivedMs > SILENT_MS;
  }

  /** Show the newest state; the condition that is shown for it. The same one's words change only when they can be read.
   * @type {(situation: Situation, isRead: boolean) => Condition} */
  show(situation, isRead) {
    this.#connected = true;
    this.#receivedMs = performance.now();
    return this.#show(conditionOf(situation, this.#whose, this.#said), isRead);
  }

  /** @type {(newest: Condition, isRead: boolean) => Condition} */
  #show(newest, isRead) {
    const condition = this.#steady.show(newest, performance.now());
    const isSame = this.#state.dataset.state === condition.name;
    if (isSame && !isRead) return condition; // figures in it change all the time
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

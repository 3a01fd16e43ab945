// The assist: what the robot offers to do by itself, and the key that is held to ask for it.
/** @import { Robot } from "../model/messages.d.ts" */
import { element, tagged } from "./elements.js";
import { HoldKey } from "./hold_key.js";
import { mark, put } from "./words.js";

export class AssistKey {
  /** The target that was offered when the key went down; null while it is up.
   * @type {string | null} */
  asked = null;
  /** @type {string | null} */
  #offered = null;
  #row = element("assist-row");
  #button = tagged("button", "assist");
  #words = element("assist-words");
  #key;
  #changed;

  /** @param {() => void} changed */
  constructor(changed) {
    this.#changed = changed;
    this.#key = new HoldKey(this.#button, "KeyA", () => this.#ask());
  }

  release() {
    this.#key.release();
  }

  /** Show what is offered or why nothing is; a cell without targets shows nothing.
   * @type {(robot: Robot | null, operates: boolean) => void} */
  show(robot, operates) {
    const assist = robot === null || robot.silent ? null : robot.assist;
    this.#row.hidden = assist === null;
    this.#button.disabled = !operates;
    this.#offered = assist !== null && assist.phase === "offered" && operates ? (assist.target?.name ?? null) : null;
    mark(this.#row, "data-phase", assist === null ? "off" : assist.phase);
    put(this.#words, assist === null ? "" : assist.reason);
  }

  disconnected() {
    this.#offered = null;
    this.release();
    this.#button.disabled = true;
  }

  /** Only what was shown when the key went down is asked for. */
  #ask() {
    this.asked = this.#key.down ? this.#offered : null;
    this.#changed();
  }
}

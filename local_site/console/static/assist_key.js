// The assist: what the robot offers to do by itself, and the key that is held to ask for it.
import { HoldKey } from "./hold_key.js";
import { mark, put } from "./words.js";

export class AssistKey {
  /** The target that was offered when the key went down; null while it is up. */
  asked = null;
  #offered = null;
  #row = document.getElementById("assist-row");
  #button = document.getElementById("assist");
  #words = document.getElementById("assist-words");
  #key;
  #changed;

  constructor(changed) {
    this.#changed = changed;
    this.#key = new HoldKey(this.#button, "KeyA", () => this.#ask());
  }

  release() {
    this.#key.release();
  }

  /** Show what is offered or why nothing is; a cell without targets shows nothing. */
  show(robot, operates) {
    const assist = robot === null || robot.silent ? null : robot.assist;
    this.#row.hidden = assist === null;
    this.#button.disabled = !operates;
    this.#offered = assist !== null && assist.phase === "offered" && operates ? assist.target.name : null;
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

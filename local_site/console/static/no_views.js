// What stands where the pictures would be: what to type before anything was started, and that a cell has no camera.
import { element } from "./elements.js";
import { mark } from "./words.js";

/** @typedef {[tag: string, words: string, command?: string]} Line */

/** @type {Line[]} */
const START = [
  ["strong", "Nothing has been started yet"],
  ["p", "On the robot's host, type", "farhand remote --config remote.toml"],
  ["p", "On this host, type", "farhand local --config local.toml"],
  ["p", "This page goes on by itself then."],
];
const HAND_IS_HERE = START.filter(([, , command]) => !command?.startsWith("farhand local"));
/** @type {Line[]} */
const NO_STATE = [["strong", "No robot yet"], ...HAND_IS_HERE.slice(1)];
/** @type {Line[]} */
const NO_CAMERA = [["strong", "This cell has no camera"], ["p", "Look at the arm itself while you operate."]];
/** @type {Line[]} */
const RECORDED = [["strong", "No picture was recorded"]];

export class NoViews {
  #room = element("no-views");

  /** `cameras` is how many the cell has, null while no cell is known; `hasHand` whether the local site tells of a hand.
   * @type {(cameras: number | null, hasHand: boolean, isReplay: boolean) => void} */
  show(cameras, hasHand, isReplay) {
    if (cameras !== null && cameras > 0) this.#put("", []);
    else if (isReplay) this.#put("replay", RECORDED);
    else if (cameras === 0) this.#put("camera", NO_CAMERA);
    else if (hasHand) this.#put("remote", NO_STATE);
    else this.#put("both", START);
  }

  /** @type {(why: string, lines: Line[]) => void} */
  #put(why, lines) {
    if (this.#room.dataset.why === why) return;
    mark(this.#room, "data-why", why);
    this.#room.hidden = lines.length === 0;
    this.#room.replaceChildren(...lines.map(line));
  }
}

/** @type {(line: Line) => HTMLElement} */
function line([tag, words, command]) {
  const made = document.createElement(tag);
  made.textContent = command ? `${words} ` : words;
  if (command) made.append(Object.assign(document.createElement("code"), { textContent: command }));
  return made;
}

// What is drawn over a calibrated camera's picture: the ghost, the tool, and what the assist offers; each on a canvas of its own.
/** @import { Camera, Cell, Pose, Robot } from "../model/messages.d.ts" */
/** @import { Marked } from "./tool_marks.js" */
/** @import { Offer } from "./view.js" */
import { AssistMarks } from "./assist_marks.js";
import { Ghost } from "./ghost.js";
import { ToolMarks } from "./tool_marks.js";

export class ViewOverlays {
  /** The canvases, from the lowest to the uppermost. */
  canvases = ["ghost", "tools", "assist"].map((name) => Object.assign(document.createElement("canvas"), { className: name }));
  /** @type {Ghost | null} */
  #ghost = null;
  /** @type {ToolMarks | null} */
  #tools = null;
  /** @type {AssistMarks | null} */
  #assist = null;

  /** Draw for this camera; nothing for one that is not calibrated.
   * @type {(camera: Camera) => void} */
  describe(camera) {
    const [ghost, tools, assist] = this.canvases;
    const { calibration } = camera;
    const calibrated = calibration === null ? null : { ...camera, calibration };
    for (const drawing of [this.#ghost, this.#tools, this.#assist]) drawing?.clear();
    this.#ghost = calibrated && new Ghost(ghost, calibrated);
    this.#tools = calibrated && new ToolMarks(tools, calibrated);
    this.#assist = calibrated && new AssistMarks(assist, calibrated);
  }

  /** Draw the commanded arm of a robot, or none; whether it is drawn.
   * @type {(cell: Cell, robot: Robot | null) => boolean} */
  showGhost(cell, robot) {
    if (robot === null) this.#ghost?.clear();
    else this.#ghost?.draw(cell, robot);
    return robot !== null && this.#ghost !== null;
  }

  /** Draw the tools, or none; `toolThen` is where the tool was measured when the picture was taken.
   * @type {(tools: Marked | null, toolThen: Pose | null) => void} */
  markTools(tools, toolThen) {
    if (tools === null) this.#tools?.clear();
    else this.#tools?.draw(tools, toolThen);
  }

  /** Draw what the assist offers, or nothing.
   * @type {(assist: Offer | null, toolThen: Pose | null) => void} */
  offer(assist, toolThen) {
    if (assist === null) this.#assist?.clear();
    else this.#assist?.draw(assist, toolThen);
  }
}

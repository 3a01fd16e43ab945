// What is drawn over a calibrated camera's picture: the ghost, the tool, and what the assist offers; each on a canvas of its own.
import { AssistMarks } from "./assist_marks.js";
import { Ghost } from "./ghost.js";
import { ToolMarks } from "./tool_marks.js";

export class ViewOverlays {
  /** The canvases, from the lowest to the uppermost. */
  canvases = [0, 1, 2].map(() => document.createElement("canvas"));
  #ghost = null;
  #tools = null;
  #assist = null;

  /** Draw for this camera; nothing for one that is not calibrated. */
  describe(camera) {
    const [ghost, tools, assist] = this.canvases;
    const isKnown = camera.calibration !== null;
    for (const drawing of [this.#ghost, this.#tools, this.#assist]) drawing?.clear();
    this.#ghost = isKnown ? new Ghost(ghost, camera) : null;
    this.#tools = isKnown ? new ToolMarks(tools, camera) : null;
    this.#assist = isKnown ? new AssistMarks(assist, camera) : null;
  }

  /** Draw the commanded arm of a robot, or none; whether it is drawn. */
  showGhost(cell, robot) {
    if (robot === null) this.#ghost?.clear();
    else this.#ghost?.draw(cell, robot);
    return robot !== null && this.#ghost !== null;
  }

  /** Draw the tools, or none; `toolThen` is where the tool was measured when the picture was taken. */
  markTools(tools, toolThen) {
    if (tools === null) this.#tools?.clear();
    else this.#tools?.draw(tools, toolThen);
  }

  /** Draw what the assist offers, or nothing. */
  offer(assist, toolThen) {
    if (assist === null) this.#assist?.clear();
    else this.#assist?.draw(assist, toolThen);
  }
}

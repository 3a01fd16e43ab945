// The ghost: the commanded arm, drawn over the picture of a calibrated camera; pure but for the drawing.
/** @import { CalibratedCamera, Cell, Robot } from "../model/messages.d.ts" */
/** @import { Pixel } from "./projection.js" */
import { frames, fromPose, inverse, origin, toolOf } from "./kinematics.js";
import { growth } from "./letters.js";
import { clipped, fitted, moved, projected } from "./projection.js";
import { LastDrawn, sized, within } from "./surface.js";

const AXIS_M = 0.05;
const STEP_PX = 0.25;
/** @type {[string, number][]} */
const STROKES = [["#000000a0", 5], ["#c9a5ff", 2.5]]; // seen on light and dark pictures alike

export class Ghost {
  #canvas;
  #context;
  #camera;
  #last = new LastDrawn(STEP_PX);

  /** Draws over a canvas's picture; `camera` is its description by the cell.
   * @param {HTMLCanvasElement} canvas @param {CalibratedCamera} camera */
  constructor(canvas, camera) {
    this.#canvas = canvas;
    this.#context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    this.#camera = camera;
  }

  /** @type {(cell: Cell, robot: Robot) => void} */
  draw(cell, robot) {
    const { width, height } = sized(this.#canvas, this.#context);
    const lines = ghostLines(cell, robot, this.#camera).map((line) => line.map((pixel) => fitted(pixel, this.#camera, width, height)));
    if (!this.#last.differs(lines, width, height, devicePixelRatio)) return;
    this.#erase();
    within(this.#context, this.#camera, { width, height }, () => {
      for (const [tone, thick] of STROKES) {
        this.#context.strokeStyle = tone;
        this.#context.lineWidth = thick * growth();
        this.#context.lineCap = this.#context.lineJoin = "round";
        for (const line of lines) this.#line(line);
      }
    });
  }

  clear() {
    if (this.#last.differs(null)) this.#erase();
  }

  #erase() {
    this.#context.clearRect(0, 0, this.#canvas.width, this.#canvas.height);
  }

  /** @type {(line: Pixel[]) => void} */
  #line([from, to]) {
    this.#context.beginPath();
    this.#context.moveTo(...from);
    this.#context.lineTo(...to);
    this.#context.stroke();
  }
}

/** The commanded arm as lines of two pixels each in the camera's full picture: from joint to joint, and the tool's axes.
 * @type {(cell: Cell, robot: Pick<Robot, "q_commanded" | "base_T_tool">, camera: Pick<CalibratedCamera, "calibration">) => Pixel[][]} */
export function ghostLines(cell, robot, { calibration }) {
  const found = frames(cell, robot.q_commanded);
  const seen_T_base = calibration.on_tool ? inverse(fromPose(robot.base_T_tool)) : null;
  const tool = toolOf(found);
  const points = found.map(origin);
  const lines = points.slice(1).map((to, k) => [points[k], to]);
  for (const axis of [0, 1, 2]) {
    lines.push([origin(tool), origin(tool).map((v, row) => v + AXIS_M * tool[4 * row + axis])]);
  }
  return lines.map((line) => clipped(line.map((point) => projected(calibration.projection, moved(seen_T_base, point))))).filter((line) => line !== null);
}

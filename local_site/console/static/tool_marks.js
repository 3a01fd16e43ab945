// The tool over a calibrated camera's picture: a ring where it was measured, a cross where it has been sent.
/** @import { CalibratedCamera, Pose, ToolPoses, Vector } from "../model/messages.d.ts" */
/** @import { Pixel } from "./projection.js" */
import { drawBack } from "./back_arrow.js";
import { fromPose, inverse, origin } from "./kinematics.js";
import { growth, letter } from "./letters.js";
import { clipped, fitted, moved, projected } from "./projection.js";
import { LastDrawn, sized, within } from "./surface.js";

/** @typedef {{ at: Pixel, ahead: Pixel[] }} Mark */
/** @typedef {ToolPoses & { limit: string | null }} Marked */

const AHEAD_M = 0.06; // how much of the tool's axis is drawn
const STEP_PX = 0.25;
const RING = 0.64; // in letters
const CROSS = [0.36, 1.2]; // its arms begin and end beside the ring, so that each shows when both are at one place
const DARK = "#000000b0";
const TONES = { measured: "#76bbff", sent: "#ffd479", between: "#ffffff" };

export class ToolMarks {
  #canvas;
  #context;
  #camera;
  #last = new LastDrawn(STEP_PX);

  /** Draws on a canvas over a picture; `camera` is its description by the cell.
   * @param {HTMLCanvasElement} canvas @param {CalibratedCamera} camera */
  constructor(canvas, camera) {
    this.#canvas = canvas;
    this.#context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    this.#camera = camera;
  }

  /**
   * `toolThen` is the measured tool when the picture was taken: a camera on the tool saw the cell from there. At a
   * `limit`, by its name, an arrow shows where the hand gets back from it.
   * @type {(tools: Marked, toolThen: Pose | null) => void}
   */
  draw({ measured, sent, wanted, limit }, toolThen) {
    const { width, height } = sized(this.#canvas, this.#context);
    const ring = markOf(measured, this.#camera, toolThen, width, height);
    const cross = markOf(sent, this.#camera, toolThen, width, height);
    /** @type {(position: Vector) => Pixel | null} */
    const project = (position) => measured && (markOf({ ...measured, position }, this.#camera, toolThen, width, height)?.at ?? null);
    const back = limit && measured && [limit, project(measured.position), wanted && project(wanted)];
    if (!this.#last.differs(ring, cross, back, width, height, letter(), devicePixelRatio)) return;
    this.#erase();
    within(this.#context, this.#camera, { width, height }, () => {
      if (ring && cross) this.#stroke([[ring.at, cross.at]], TONES.between, 1);
      if (ring) this.#measured(ring);
      if (cross) this.#sent(cross);
      if (ring && limit && measured) drawBack(this.#context, project, measured.position, wanted, limit);
    });
  }

  clear() {
    if (this.#last.differs(null)) this.#erase();
  }

  #erase() {
    this.#context.clearRect(0, 0, this.#canvas.width, this.#canvas.height);
  }

  /** @type {(mark: Mark) => void} */
  #measured({ at: [x, y], ahead }) {
    this.#stroke([ahead], TONES.measured, 2);
    for (const { tone, thick } of [{ tone: DARK, thick: 5 }, { tone: TONES.measured, thick: 2.5 }]) {
      this.#context.strokeStyle = tone;
      this.#context.lineWidth = thick * growth();
      this.#context.beginPath();
      this.#context.arc(x, y, RING * letter(), 0, 2 * Math.PI);
      this.#context.stroke();
    }
  }

  /** @type {(mark: Mark) => void} */
  #sent({ at: [x, y], ahead }) {
    this.#context.setLineDash([4, 4]);
    this.#stroke([ahead], TONES.sent, 2);
    this.#context.setLineDash([]);
    const [near, far] = CROSS.map((letters) => letters * letter());
    /** @type {Pixel[]} */
    const arms = [[1, 0], [-1, 0], [0, 1], [0, -1]];
    this.#stroke(arms.map(([u, v]) => [[x + near * u, y + near * v], [x + far * u, y + far * v]]), TONES.sent, 2.5);
  }

  /** Lines with a dark edge, so that they are seen on light and dark pictures alike.
   * @type {(lines: Pixel[][], tone: string, thick: number) => void} */
  #stroke(lines, tone, thick) {
    this.#context.lineCap = "round";
    for (const { colour, width } of [{ colour: DARK, width: thick + 2.5 }, { colour: tone, width: thick }]) {
      this.#context.strokeStyle = colour;
      this.#context.lineWidth = width * growth();
      this.#context.beginPath();
      for (const [from, to] of lines) {
        this.#context.moveTo(...from);
        this.#context.lineTo(...to);
      }
      this.#context.stroke();
    }
  }
}

/** Where a tool and its axis are on the canvas; null where it is not known, or not in front of the camera.
 * @type {(tool: Pose | null, camera: CalibratedCamera, toolThen: Pose | null, width: number, height: number) => Mark | null} */
function markOf(tool, camera, toolThen, width, height) {
  if (tool === null || (camera.calibration.on_tool && toolThen === null)) return null;
  const { projection, on_tool } = camera.calibration;
  const seen_T_base = on_tool && toolThen !== null ? inverse(fromPose(toolThen)) : null;
  const base_T_tool = fromPose(tool);
  const tip = origin(base_T_tool).map((v, row) => v + AHEAD_M * base_T_tool[4 * row + 2]);
  const seen = [origin(base_T_tool), tip].map((point) => projected(projection, moved(seen_T_base, point)));
  const [alone, axis] = [clipped([seen[0], seen[0]]), clipped(seen)];
  if (alone === null || axis === null) return null;
  const [at, ...ahead] = [alone[0], ...axis].map((pixel) => fitted(pixel, camera, width, height));
  return { at, ahead };
}

// What the assist offers, over a calibrated camera's picture: the marker's border, and the gripper where it would be.
/** @import { Assist, AssistTarget, CalibratedCamera, Pose, Vector } from "../model/messages.d.ts" */
import { fromPose, inverse } from "./kinematics.js";
import { clipped, fitted, moved, projected } from "./projection.js";
import { LastDrawn, sized } from "./surface.js";

const STEP_PX = 0.25;
const DARK = "#000000b0";
const TONES = { off: "#b8c0c8", offered: "#8be08b", leading: "#ffd479", ended: "#b8c0c8" };
const FINGERS = [[0.036, 0], [0.036, -0.035], [-0.036, -0.035], [-0.036, 0]]; // y and z from the tool centre point, m
const WRIST = [[0, -0.035], [0, -0.09]];

export class AssistMarks {
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

  /** `toolThen` is the measured tool when the picture was taken: a camera on the tool saw the cell from there.
   * @type {(assist: Pick<Assist, "phase"> & { target: AssistTarget }, toolThen: Pose | null) => void} */
  draw({ phase, target }, toolThen) {
    const { projection, on_tool } = this.#camera.calibration;
    if (on_tool && toolThen === null) {
      this.clear();
      return;
    }
    const { width, height } = sized(this.#canvas, this.#context);
    const seen_T_base = on_tool && toolThen !== null ? inverse(fromPose(toolThen)) : null;
    const lines = outline(target).map((line) => line.map((point) => projected(projection, moved(seen_T_base, point))));
    const shown = lines.map(clipped).filter((line) => line !== null);
    if (!this.#last.differs(phase, shown, width, height, devicePixelRatio)) return;
    this.#erase();
    for (const { tone, thick } of [{ tone: DARK, thick: 5 }, { tone: TONES[phase], thick: 2 }]) {
      this.#context.strokeStyle = tone;
      this.#context.lineWidth = thick;
      this.#context.lineCap = "round";
      this.#context.beginPath();
      for (const line of shown) {
        const [from, to] = line.map((pixel) => fitted(pixel, this.#camera, width, height));
        this.#context.moveTo(...from);
        this.#context.lineTo(...to);
      }
      this.#context.stroke();
    }
  }

  clear() {
    if (this.#last.differs(null)) this.#erase();
  }

  #erase() {
    this.#context.clearRect(0, 0, this.#canvas.width, this.#canvas.height);
  }
}

/** The lines between points of the base's frame: the marker's border, and the gripper at the target.
 * @type {(target: AssistTarget) => Vector[][]} */
export function outline({ base_T_marker, size, base_T_tool }) {
  const half = size / 2;
  const corners = [[-half, half], [half, half], [half, -half], [-half, -half]];
  const [marker, tool] = [base_T_marker, base_T_tool].map(fromPose);
  const border = corners.map(([x, y]) => moved(marker, [x, y, 0]));
  const [fingers, wrist] = [FINGERS, WRIST].map((points) => points.map(([y, z]) => moved(tool, [0, y, z])));
  return [...chain([...border, border[0]]), ...chain(fingers), ...chain(wrist)];
}

/** @type {(points: Vector[]) => Vector[][]} */
function chain(points) {
  return points.slice(1).map((point, k) => [points[k], point]);
}

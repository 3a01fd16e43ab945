// The ghost: the commanded arm, drawn over the picture of a calibrated camera; pure but for the drawing.
import { frames, fromPose, inverse, multiply, origin } from "./kinematics.js";
import { sized } from "./surface.js";

const AXIS_M = 0.05;
const STROKES = [["#000000a0", 5], ["#c9a5ff", 2.5]]; // seen on light and dark pictures alike
const NEAREST_M = 0.03; // what is nearer to the camera, or behind it, is clipped

export class Ghost {
  #canvas;
  #context;
  #camera;

  /** Draws over a canvas's picture; `camera` is its description by the cell. */
  constructor(canvas, camera) {
    this.#canvas = canvas;
    this.#context = canvas.getContext("2d");
    this.#camera = camera;
  }

  draw(cell, robot) {
    const { width, height } = sized(this.#canvas, this.#context);
    this.clear();
    const lines = ghostLines(cell, robot, this.#camera).map((line) => line.map((pixel) => fitted(pixel, this.#camera, width, height)));
    for (const [tone, thick] of STROKES) {
      this.#context.strokeStyle = tone;
      this.#context.lineWidth = thick;
      this.#context.lineCap = this.#context.lineJoin = "round";
      for (const line of lines) this.#line(line);
    }
  }

  clear() {
    this.#context.clearRect(0, 0, this.#canvas.width, this.#canvas.height);
  }

  #line([from, to]) {
    this.#context.beginPath();
    this.#context.moveTo(...from);
    this.#context.lineTo(...to);
    this.#context.stroke();
  }
}

/** The commanded arm as lines of two pixels each in the camera's full picture: from joint to joint, and the tool's axes. */
export function ghostLines(cell, robot, { calibration }) {
  const found = frames(cell, robot.q_commanded);
  const seen_T_base = calibration.on_tool ? inverse(fromPose(robot.base_T_tool)) : null;
  const tool = found.at(-1);
  const points = found.map(origin);
  const lines = points.slice(1).map((to, k) => [points[k], to]);
  for (const axis of [0, 1, 2]) {
    lines.push([origin(tool), origin(tool).map((v, row) => v + AXIS_M * tool[4 * row + axis])]);
  }
  return lines.map((line) => clipped(line.map((point) => projected(calibration.projection, moved(seen_T_base, point))))).filter(Boolean);
}

function moved(transform, [x, y, z]) {
  return transform === null ? [x, y, z] : origin(multiply(transform, [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1]));
}

/** Homogeneous pixels: across and down times depth, and depth. */
function projected(p, [x, y, z]) {
  return [0, 4, 8].map((row) => p[row] * x + p[row + 1] * y + p[row + 2] * z + p[row + 3]);
}

/** The part of a line that is in front of the camera, in pixels; null where none is. */
function clipped([a, b]) {
  if (a[2] < NEAREST_M && b[2] < NEAREST_M) return null;
  const cut = (from, to) => {
    if (from[2] >= NEAREST_M) return from;
    const fraction = (NEAREST_M - from[2]) / (to[2] - from[2]);
    return from.map((v, k) => v + fraction * (to[k] - v));
  };
  return [cut(a, b), cut(b, a)].map(([u, v, w]) => [u / w, v / w]);
}

/** Where a pixel of the full picture is on a canvas that shows it as large as it fits. */
function fitted([u, v], { width: full, height: tall }, width, height) {
  const scale = Math.min(width / full, height / tall);
  return [(width - scale * full) / 2 + scale * u, (height - scale * tall) / 2 + scale * v];
}

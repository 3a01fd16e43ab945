// Forward kinematics of the joints and the tool: 4 x 4 transforms, row by row, from the cell's description; pure.
/** @import { Cell, Joint, Pose, Quaternion, Vector } from "../model/messages.d.ts" */

/** @typedef {number[]} Transform 4 x 4, row by row */

export const IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

/** @type {(a: Transform, b: Transform) => Transform} */
export function multiply(a, b) {
  const product = new Array(16);
  for (let row = 0; row < 4; row++) {
    for (let column = 0; column < 4; column++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[4 * row + k] * b[4 * k + column];
      product[4 * row + column] = sum;
    }
  }
  return product;
}

/** The transform of a pose: position in m, quaternion x, y, z, w.
 * @type {(pose: Pose) => Transform} */
export function fromPose({ position: [px, py, pz], orientation: [x, y, z, w] }) {
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), px,
    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), py,
    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), pz,
    0, 0, 0, 1,
  ];
}

/** @type {(joint: Pick<Joint, "axis" | "slides">, value: number) => Transform} */
function motion({ axis: [x, y, z], slides }, value) {
  if (slides) return fromPose({ position: [x * value, y * value, z * value], orientation: [0, 0, 0, 1] });
  const s = Math.sin(value / 2);
  return fromPose({ position: [0, 0, 0], orientation: [x * s, y * s, z * s, Math.cos(value / 2)] });
}

/** The frames of the base, every joint and the tool, at joint positions in rad (m where a joint slides).
 * @type {(cell: Pick<Cell, "joints" | "last_T_tool">, q: number[]) => Transform[]} */
export function frames(cell, q) {
  const found = [IDENTITY];
  let frame = IDENTITY;
  cell.joints.forEach((joint, k) => {
    frame = multiply(multiply(frame, fromPose(joint.parent_T_joint)), motion(joint, q[k]));
    found.push(frame);
  });
  return [...found, multiply(frame, fromPose(cell.last_T_tool))];
}

/** The tool's of such frames.
 * @type {(found: Transform[]) => Transform} */
export const toolOf = (found) => found[found.length - 1];

/** The inverse of a rigid transform.
 * @type {(transform: Transform) => Transform} */
export function inverse([a, b, c, x, d, e, f, y, g, h, i, z]) {
  return [a, d, g, -(a * x + d * y + g * z), b, e, h, -(b * x + e * y + h * z), c, f, i, -(c * x + f * y + i * z), 0, 0, 0, 1];
}

/** @type {(frame: Transform) => Vector} */
export const origin = (frame) => [frame[3], frame[7], frame[11]];
/** @type {(a: Vector, b: Vector) => number} */
export const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

/** The angle in degrees between two orientations, quaternions x, y, z, w.
 * @type {(a: Quaternion, b: Quaternion) => number} */
export function turnedBy(a, b) {
  const dot = Math.abs(a.reduce((sum, v, k) => sum + v * b[k], 0));
  return (360 / Math.PI) * Math.acos(Math.min(dot, 1));
}

// The solids of an arm in its posture: capsules and the gripper's fingers in the base's frame; pure.
/** @import { Cell, Gripper, Vector } from "../model/messages.d.ts" */
/** @import { Transform } from "./kinematics.js" */
import { origin, toolOf } from "./kinematics.js";
import { moved } from "./projection.js";

/** @typedef {{ start: Vector, end: Vector, radius: number, tool?: boolean, inner?: boolean, finger?: boolean }} Capsule */

const FINGER_M = { from: -0.085, to: 0.015, radius: 0.013 }; // thicker than most fingers: seen when the arm is small
const STEM_M = 0.024;
const BONE_M = 0.018;

/** The capsules of a cell with the frames of its links where they are now (`frames`); `tool`: the tool carries it.
 * @type {(cell: Cell, found: Transform[]) => Capsule[]} */
export function placedCapsules({ shapes }, found) {
  return shapes.capsules.map(({ link, start, end, radius }) => ({
    start: moved(found[link], start),
    end: moved(found[link], end),
    radius,
    tool: link === found.length - 1,
  }));
}

/** From joint to joint, without the tool: seen where the capsules, which it is inside of, leave gaps.
 * @type {(found: Transform[]) => Capsule[]} */
export function bones(found) {
  const points = found.slice(0, -1).map(origin);
  return points.slice(1).map((end, k) => ({ start: points[k], end, radius: BONE_M, inner: true }));
}

/** The gripper as measured: two fingers, the bar that they slide on, the stem. They close along y of the tool's frame.
 * @type {(cell: Cell, found: Transform[], gripper: Gripper) => Capsule[]} */
export function gripperSolids({ shapes }, found, { opening }) {
  const { from, to, radius } = FINGER_M;
  const tool = toolOf(found);
  const half = Math.max(opening, 0) / 2 + radius;
  const widest = Math.max(opening, shapes.gripper.open) / 2 + radius;
  /** @type {(a: Vector, b: Vector, finger?: boolean) => Capsule} */
  const part = (a, b, finger = false) => ({ start: moved(tool, a), end: moved(tool, b), radius, finger });
  return [
    { start: origin(found[found.length - 2]), end: moved(tool, [0, 0, from - STEM_M]), radius: STEM_M },
    part([0, -widest, from], [0, widest, from]),
    part([0, -half, from + radius], [0, -half, to], true),
    part([0, half, from + radius], [0, half, to], true),
  ];
}

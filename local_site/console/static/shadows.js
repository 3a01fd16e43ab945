// Shadows straight below the arm, on the table and other tops: they show how high it is above them.
/** @import { Box, Vector } from "../model/messages.d.ts" */
/** @import { Capsule } from "./arm_solids.js" */
/** @import { Pen } from "./pen.js" */

const DARK = 0.45; // alpha
const SIDES = 10; // of each rounded end

/** The outline of a capsule's shadow on a level plane at height `z` (m), as points in turn.
 * @type {(capsule: Capsule, z: number) => Vector[]} */
export function shadow({ start, end, radius }, z) {
  const along = Math.atan2(end[1] - start[1], end[0] - start[0]);
  /** @type {(centre: Vector, from: number) => Vector[]} */
  const around = (centre, from) =>
    Array.from({ length: SIDES + 1 }, (_, k) => {
      const angle = from + (Math.PI * k) / SIDES;
      return [centre[0] + radius * Math.cos(angle), centre[1] + radius * Math.sin(angle), z];
    });
  return [...around(start, along + Math.PI / 2), ...around(end, along - Math.PI / 2)];
}

/** Whether a capsule is above a level plane.
 * @type {(capsule: Capsule, z: number) => boolean} */
export const isAbove = ({ start, end }, z) => Math.min(start[2], end[2]) > z;

/** Draw the shadows of capsules on the area between corners in turn, all at one height.
 * @type {(pen: Pen, capsules: Capsule[], corners: Vector[]) => void} */
export function drawShadows(pen, capsules, corners) {
  const { context } = pen;
  if (!pen.trace(corners)) return;
  context.save();
  context.clip();
  context.globalAlpha = DARK;
  context.fillStyle = "#000000";
  context.beginPath();
  const z = corners[0][2];
  for (const capsule of capsules) if (isAbove(capsule, z)) pen.append(shadow(capsule, z));
  context.fill();
  context.restore();
}

/** The height (m) of the highest of some boxes' tops that is straight below a point; null where there is none.
 * @type {(point: Vector, boxes: Box[]) => number | null} */
export function topBelow([x, y, z], boxes) {
  const inside = boxes.filter(({ lower, upper }) => lower[0] <= x && x <= upper[0] && lower[1] <= y && y <= upper[1]);
  const tops = inside.map(({ upper }) => upper[2]).filter((top) => top <= z);
  return tops.length === 0 ? null : Math.max(...tops);
}

/** Draw a line straight down from a point to the height `z`.
 * @type {(pen: Pen, point: Vector, z: number, tone: string) => void} */
export function drawPlumb(pen, point, z, tone) {
  const foot = [point[0], point[1], z];
  pen.context.globalAlpha = 0.7;
  pen.line([point, foot], tone, 1);
  pen.disc(foot, tone, 2);
  pen.context.globalAlpha = 1;
}

// The fixtures of a cell as faint solids: the faces that are seen, their edges, and walls that fade out downward.
/** @import { Box, Vector } from "../model/messages.d.ts" */
/** @import { Pen } from "./pen.js" */

/** @typedef {{ axis: number, top: boolean, corners: Vector[] }} Face */

const FACES = [0, 1, 2].flatMap((axis) => [false, true].map((high) => ({ axis, high })));
const TALLEST_M = 0.3; // of a wall: what is below tells nothing of the arm
const TOP = 0.36; // alpha
const WALLS = [0.3, 0.2]; // alpha at their upper edges, across x and y
const EDGE_PX = 1.2;

/** The faces of a box that a point sees: their four corners in turn, in the base's frame, the axis across, and the top.
 * @type {(box: Box, eye: Vector) => Face[]} */
export function seenFaces({ lower, upper }, eye) {
  const seen = FACES.filter(({ axis, high }) => (high ? eye[axis] > upper[axis] : eye[axis] < lower[axis]));
  return seen.map(({ axis, high }) => ({ axis, top: axis === 2 && high, corners: corners(lower, upper, axis, high) }));
}

/** The corners of a face in turn: of a wall the two lower ones first.
 * @type {(lower: Vector, upper: Vector, axis: number, high: boolean) => Vector[]} */
function corners(lower, upper, axis, high) {
  const [one, other] = [0, 1, 2].filter((k) => k !== axis);
  return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([a, b]) => {
    const point = [0, 0, 0];
    point[axis] = (high ? upper : lower)[axis];
    point[one] = (a ? upper : lower)[one];
    point[other] = (b ? upper : lower)[other];
    return point;
  });
}

/** @type {(pen: Pen, box: Box, eye: Vector, tone: string) => void} */
export function drawFixture(pen, { lower, upper }, eye, tone) {
  const shown = { lower: [lower[0], lower[1], Math.max(lower[2], upper[2] - TALLEST_M)], upper };
  for (const { top, axis, corners: points } of seenFaces(shown, eye)) {
    if (top) {
      pen.fill(points, tone, TOP);
      pen.line([...points, points[0]], tone, EDGE_PX);
    } else if (axis !== 2) drawWall(pen, points, tone, WALLS[axis]);
  }
}

/** @type {(pen: Pen, face: Vector[], tone: string, alpha: number) => void} */
function drawWall(pen, [a, b, c, d], tone, alpha) {
  const fading = fade(pen, c, b, tone);
  if (fading === null) return;
  pen.fill([a, b, c, d], fading, alpha);
  pen.line([a, d], fading, EDGE_PX);
  pen.line([b, c], fading, EDGE_PX);
}

/** A tone that is gone at the lower of two points.
 * @type {(pen: Pen, high: Vector, low: Vector, tone: string) => CanvasGradient | null} */
function fade(pen, high, low, tone) {
  const [from, to] = [pen.project(high), pen.project(low)];
  if (from === null || to === null) return null;
  const gradient = pen.context.createLinearGradient(from[0], from[1], from[0], to[1]);
  gradient.addColorStop(0, tone);
  gradient.addColorStop(1, `${tone}00`);
  return gradient;
}

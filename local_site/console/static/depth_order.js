// The painter's order of capsules and boxes: what is behind is painted first; pure.
/** @import { Box, Vector } from "../model/messages.d.ts" */
/** @import { Capsule } from "./arm_solids.js" */
/** @import { Eye } from "./orbit.js" */
import { dot, middle, minus } from "./vectors.js";

/** @typedef {{ capsule: Capsule, box?: undefined } | { capsule?: undefined, box: Box }} Item */

/** Items as indices, the farthest first. `away[k]` is how far one is; `before(a, b)` says that a has to precede b.
 * @type {(away: number[], before: (a: number, b: number) => boolean) => number[]} */
export function paintOrder(away, before) {
  const left = away.map((_, k) => k).sort((a, b) => away[b] - away[a]);
  /** @type {number[]} */
  const order = [];
  while (left.length > 0) {
    const free = left.findIndex((b) => !left.some((a) => a !== b && before(a, b)));
    order.push(...left.splice(Math.max(free, 0), 1)); // around a circle of items the farthest begins
  }
  return order;
}

/** Whether a capsule is painted before a box, seen from a point: true, false, or null where that does not matter.
 *
 * A face that has the capsule on its outer side separates both: the capsule is in front if the eye is on that side too.
 * @type {(capsule: Pick<Capsule, "start" | "end">, box: Box, eye: Vector) => boolean | null}
 */
export function isBehindBox({ start, end }, { lower, upper }, eye) {
  let farthest = 0;
  let behind = null;
  for (const axis of [0, 1, 2]) {
    for (const [side, face] of [[-1, lower[axis]], [1, upper[axis]]]) {
      const outside = Math.min(side * (start[axis] - face), side * (end[axis] - face));
      if (outside <= farthest) continue;
      farthest = outside;
      behind = side * (eye[axis] - face) <= 0;
    }
  }
  return behind;
}

/** Whether one box is behind another that it does not overlap.
 * @type {(one: Box, other: Box, eye: Vector) => boolean} */
export function isBoxBehind(one, other, eye) {
  for (const axis of [0, 1, 2]) {
    if (one.lower[axis] >= other.upper[axis]) return eye[axis] <= other.upper[axis];
    if (one.upper[axis] <= other.lower[axis]) return eye[axis] >= other.lower[axis];
  }
  return false;
}

/** Capsules and boxes together, in the order in which they are painted; `inner` capsules before all others.
 * @type {(capsules: Capsule[], boxes: Box[], eye: Pick<Eye, "position" | "toward">) => Item[]} */
export function ordered(capsules, boxes, { position, toward }) {
  /** @type {(point: Vector) => number} */
  const away = (point) => -dot(toward, minus(point, position));
  /** @type {Item[]} */
  const items = [...capsules.map((capsule) => ({ capsule })), ...boxes.map((box) => ({ box }))];
  const distances = items.map(({ capsule, box }) =>
    capsule ? away(middle(capsule.start, capsule.end)) - capsule.radius : away(middle(box.lower, box.upper)),
  );
  /** @type {(a: number, b: number) => boolean} */
  const before = (a, b) => {
    const [one, other] = [items[a], items[b]];
    if (one.box) return other.box ? isBoxBehind(one.box, other.box, position) : isBehindBox(other.capsule, one.box, position) === false;
    if (other.box) return isBehindBox(one.capsule, other.box, position) === true;
    const [inner, outer] = [one.capsule.inner === true, other.capsule.inner === true];
    return inner === outer ? distances[a] > distances[b] : inner;
  };
  return paintOrder(distances, before).map((k) => items[k]);
}

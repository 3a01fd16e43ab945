// Where the hand pushes against a limit: as a direction for the arrow, and as words for the way back; pure.
import { distance } from "./kinematics.js";

const LEAST_PUSH_M = 0.004; // a limit of the orientation alone has no direction
const MAIN_SHARE = 0.5; // of the push along an axis from which on it is named,
const NAMED_SHARE = 0.35; // and below which it is no longer: words that come and go are not read
// Against the push along x, y, z of the base, for the operator: forward, left and up are the robot's own.
const BACK = [["towards you", "away from you"], ["to the right", "to the left"], ["down", "up"]];

/** The unit vector (base) from the tool to where the hand wants it; null where the hand pushes in no direction, or it is not known. */
export function pushOf(tool, wanted) {
  if (wanted === null) return null;
  const push = distance(tool, wanted);
  return push < LEAST_PUSH_M ? null : tool.map((v, axis) => (wanted[axis] - v) / push);
}

/** In which directions the hand gets back from a limit, in words that do not flicker. */
export class WayBack {
  #named = new Set();

  /** "down and to the left", of the tools as the console tells them; empty where no direction is known. */
  words({ measured, wanted }) {
    const push = measured === null ? null : pushOf(measured.position, wanted);
    const share = (axis) => (this.#named.has(axis) ? NAMED_SHARE : MAIN_SHARE);
    const axes = push === null ? [] : [0, 1, 2].filter((axis) => Math.abs(push[axis]) >= share(axis));
    this.#named = new Set(axes);
    return axes.map((axis) => BACK[axis][push[axis] > 0 ? 0 : 1]).join(" and ");
  }
}

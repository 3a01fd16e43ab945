// Where the hand gets back from a limit: as a direction for the arrow, and in words; pure.
/** @import { ToolPoses, Vector } from "../model/messages.d.ts" */
import { distance } from "./kinematics.js";

const LEAST_AWAY_M = 0.004; // a limit of the orientation alone has no direction
const MAIN_SHARE = 0.5; // of the way back along an axis from which on it is named,
const NAMED_SHARE = 0.35; // and below which it is no longer: words that come and go are not read
// Along x, y, z of the base and against them, for the operator: forward, left and up are the robot's own.
const NAMES = [["away from you", "towards you"], ["to your left", "to your right"], ["up", "down"]];

/** The unit vector (base) from where the hand wants the tool to the tool; null where there is no direction, or it is not known.
 * @type {(tool: Vector, wanted: Vector | null) => Vector | null} */
export function wayBack(tool, wanted) {
  if (wanted === null) return null;
  const away = distance(tool, wanted);
  return away < LEAST_AWAY_M ? null : tool.map((v, axis) => (v - wanted[axis]) / away);
}

/** The way back in words that do not flicker. */
export class WayBack {
  /** @type {Set<number>} */
  #named = new Set();

  /** "down and to your left", of the tools as the console tells them; empty where no direction is known.
   * @type {(tools: Pick<ToolPoses, "measured" | "wanted">) => string} */
  words({ measured, wanted }) {
    const back = measured === null ? null : wayBack(measured.position, wanted);
    /** @type {(axis: number) => number} */
    const share = (axis) => (this.#named.has(axis) ? NAMED_SHARE : MAIN_SHARE);
    const axes = [0, 1, 2].filter((axis) => back !== null && Math.abs(back[axis]) >= share(axis));
    this.#named = new Set(axes);
    return axes.map((axis) => NAMES[axis][back !== null && back[axis] > 0 ? 0 : 1]).join(" and ");
  }
}

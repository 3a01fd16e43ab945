// How near joints are to their limits, and in which words; pure.
/** @import { Cell } from "../model/messages.d.ts" */

/** @typedef {{ joint: number, way: number, gap: number, at: boolean, near: boolean, used: number }} Limit */
/** @typedef {Pick<Cell, "joints">} Jointed */

const NEAR = { turn: (15 * Math.PI) / 180, slide: 0.15 }; // rad, or a fraction of the range where it slides
const AT = { turn: (4 * Math.PI) / 180, slide: 0.04 };

/** The joints near a limit, nearest first: which joint, the signed way to the limit (rad or m), and whether it is there.
 * @type {(cell: Jointed, q: number[]) => Limit[]} */
export function nearLimits({ joints }, q) {
  const found = joints.map((joint, k) => {
    const [down, up] = [q[k] - joint.lower, joint.upper - q[k]];
    const gap = Math.max(Math.min(down, up), 0);
    const share = joint.slides ? gap / (joint.upper - joint.lower) : gap;
    const kind = joint.slides ? "slide" : "turn";
    return { joint: k, way: up < down ? gap : -gap, gap, at: share < AT[kind], near: share < NEAR[kind], used: share / NEAR[kind] };
  });
  return found.filter(({ near }) => near).sort((a, b) => a.used - b.used);
}

/** What is left to a limit: degrees, or mm where the joint slides.
 * @type {(cell: Jointed, limit: Limit) => string} */
export function gapWords({ joints }, { joint, gap }) {
  return joints[joint].slides ? `${(1000 * gap).toFixed(0)} mm` : `${((180 / Math.PI) * gap).toFixed(0)}°`;
}

/** A sentence's part that names the joints near their limits; empty where none is.
 * @type {(cell: Jointed, q: number[]) => string} */
export function limitWords(cell, q) {
  const near = nearLimits(cell, q);
  const named = near.map((limit) => `${cell.joints[limit.joint].name} ${gapWords(cell, limit)}`);
  return named.length === 0 ? "" : `${named.join(", ")} from ${named.length === 1 ? "its limit" : "their limits"}`;
}

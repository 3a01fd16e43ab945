// Solid capsules: the outline of two circles and their tangents, filled with Lambert's shade across the axis.
/** @import { Vector } from "../model/messages.d.ts" */
/** @import { Capsule } from "./arm_solids.js" */
/** @import { Colour } from "./colours.js" */
/** @import { Eye, Project, Sight } from "./orbit.js" */
import { css, mixed, rgb } from "./colours.js";
import { dot, minus, unit } from "./vectors.js";

/** @typedef {[number, number, number]} Circle x, y, radius, in pixels */

const LIGHT = unit([-0.45, 0.62, 0.65]); // to the right, up, and toward the eye
const ACROSS = [-1, -0.8, -0.5, 0, 0.5, 0.8, 1]; // where the shade is computed, in radii from the axis
const END_ON = 0.8; // an axis that points so much at the eye shows the end's sphere
const [BLACK, WHITE] = [[0, 0, 0], [255, 255, 255]];
const [LIFT, BRIGHT] = [0.26, 200];
const DIM = 0.72; // the Lambert term at which the tone itself is seen

/** A capsule as seen: circles [x, y, radius] in pixels, the nearer one last; null where one is behind the eye.
 * @type {(capsule: Capsule, project: Project) => Circle[] | null} */
export function seenCapsule({ start, end, radius }, project) {
  const seen = [start, end].map(project);
  if (!seen.every((one) => one !== null)) return null;
  const circles = seen.map(([x, y, perMetre]) => /** @type {Circle} */ ([x, y, radius * perMetre]));
  return circles.sort((a, b) => a[2] - b[2]);
}

/** Trace the outline around two circles.
 * @type {(path: CanvasPath, circles: Circle[]) => void} */
export function traceCapsule(path, [[ax, ay, ar], [bx, by, br]]) {
  const apart = Math.hypot(bx - ax, by - ay);
  if (apart <= Math.abs(br - ar) + 0.01) {
    path.moveTo(bx + br, by);
    path.arc(bx, by, br, 0, 2 * Math.PI);
    return;
  }
  const along = Math.atan2(by - ay, bx - ax);
  const tangent = Math.acos((ar - br) / apart);
  path.moveTo(ax + ar * Math.cos(along + tangent), ay + ar * Math.sin(along + tangent));
  path.arc(ax, ay, ar, along + tangent, along - tangent + 2 * Math.PI);
  path.arc(bx, by, br, along - tangent, along + tangent);
  path.closePath();
}

/** The Lambert term (0 to 1) of a capsule's surface, `t` radii beside its axis; all in the eye's axes.
 * @type {(axis: Vector, t: number) => number} */
export function lambert(axis, t) {
  const side = unit([-axis[1], axis[0], 0], [1, 0, 0]);
  const facing = unit([-axis[2] * axis[0], -axis[2] * axis[1], 1 - axis[2] * axis[2]]);
  const rest = Math.sqrt(Math.max(0, 1 - t * t));
  return Math.max(0, t * dot(side, LIGHT) + rest * dot(facing, LIGHT));
}

/** A tone under a Lambert term; a dark one is made lighter first, so that its shades can be told apart.
 * @type {(dark: Colour, term: number) => Colour} */
export function shaded(dark, term) {
  const tone = mixed(dark, WHITE, LIFT * Number(Math.max(...dark) < BRIGHT));
  return term < DIM ? mixed(BLACK, tone, 0.3 + (0.7 * term) / DIM) : mixed(tone, WHITE, (0.3 * (term - DIM)) / (1 - DIM));
}

/** Fill a capsule seen from `sight`, its tone "#rrggbb".
 * @type {(context: CanvasRenderingContext2D, sight: Sight, capsule: Capsule, hex: string, edge: string) => void} */
export function drawCapsule(context, sight, capsule, hex, edge) {
  const seen = seenCapsule(capsule, sight.project);
  if (seen === null) return;
  const tone = rgb(hex);
  const axis = inEyesAxes(sight, unit(minus(capsule.end, capsule.start)));
  context.beginPath();
  traceCapsule(context, seen);
  context.fillStyle = Math.abs(axis[2]) > END_ON ? ball(context, seen[1], tone) : tube(context, seen, axis, tone);
  context.strokeStyle = edge;
  context.lineWidth = 1.5;
  context.stroke();
  context.fill();
}

/** @type {(eye: Eye, way: Vector) => Vector} */
function inEyesAxes({ right, up, toward }, way) {
  return [dot(way, right), dot(way, up), dot(way, toward)];
}

/** @type {(context: CanvasRenderingContext2D, circles: Circle[], axis: Vector, tone: Colour) => CanvasGradient} */
function tube(context, [[ax, ay, ar], [bx, by, br]], axis, tone) {
  const [x, y, r] = [(ax + bx) / 2, (ay + by) / 2, Math.max(ar, br)];
  const [sx, sy] = unit([-axis[1], axis[0], 0], [1, 0, 0]);
  const gradient = context.createLinearGradient(x - r * sx, y + r * sy, x + r * sx, y - r * sy);
  for (const t of ACROSS) gradient.addColorStop((t + 1) / 2, css(shaded(tone, lambert(axis, t))));
  return gradient;
}

/** @type {(context: CanvasRenderingContext2D, circle: Circle, tone: Colour) => CanvasGradient} */
function ball(context, [x, y, r], tone) {
  const gradient = context.createRadialGradient(x + LIGHT[0] * r * 0.7, y - LIGHT[1] * r * 0.7, 0, x, y, 1.25 * r);
  for (const share of [0, 0.35, 0.7, 1]) gradient.addColorStop(share, css(shaded(tone, Math.cos((share * Math.PI) / 2))));
  return gradient;
}

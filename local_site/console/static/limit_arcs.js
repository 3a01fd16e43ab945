// Arcs at the joints that are near a limit: from where the joint is to where it has to stop.
/** @import { Cell, Joint, Vector } from "../model/messages.d.ts" */
/** @import { Limit } from "./joint_limits.js" */
/** @import { Transform } from "./kinematics.js" */
/** @import { Pen } from "./pen.js" */
import { gapWords } from "./joint_limits.js";
import { origin, toolOf } from "./kinematics.js";
import { add, cross, dot, minus, times, unit } from "./vectors.js";

/** @typedef {{ axis: Vector, at: Vector, toward: Vector }} Plane */

const LEAST_PX = 32; // the arcs' radius, however small the arm is
const SHARE = 0.11; // of the canvas
const STEP = 0.05; // rad
const DIAL = 1.2; // rad of the joint's range are drawn thin, up to the limit
const THICK = 5;
const LABEL = 0.75; // of the radius: what is left is written there, on the other side of the joint

/** @type {(frame: Transform, k: number) => Vector} */
const column = (frame, k) => [frame[k], frame[4 + k], frame[8 + k]];

/** The plane in which a joint turns: its axis, its origin, and the direction from it to the tool.
 * @type {(joint: Pick<Joint, "axis">, frame: Transform, tool: Vector) => Plane} */
export function turning(joint, frame, tool) {
  const axis = unit(joint.axis.reduce((sum, v, k) => add(sum, times(column(frame, k), v)), [0, 0, 0]));
  const at = origin(frame);
  /** @type {(way: Vector) => Vector} */
  const across = (way) => minus(way, times(axis, dot(way, axis)));
  const toTool = across(minus(tool, at));
  const aside = unit(across(column(frame, 1)), unit(across(column(frame, 0))));
  return { axis, at, toward: Math.hypot(...toTool) < 0.02 ? aside : unit(toTool) };
}

/** Points on the arc from the joint's position to its limit, `way` further (rad), in the base's frame.
 * @type {(plane: Plane, way: number, radius: number) => Vector[]} */
export function arc({ axis, at, toward }, way, radius) {
  const side = cross(axis, toward);
  const steps = Math.max(1, Math.ceil(Math.abs(way) / STEP));
  return Array.from({ length: steps + 1 }, (_, k) => {
    const angle = (way * k) / steps;
    return add(at, add(times(toward, radius * Math.cos(angle)), times(side, radius * Math.sin(angle))));
  });
}

/** Draw a joint's limit; `tone` is its colour, `under` what sets it off from the arm.
 * @type {(pen: Pen, cell: Cell, limit: Limit, found: Transform[], tone: string, under: string) => void} */
export function drawLimit(pen, cell, limit, found, tone, under) {
  const joint = cell.joints[limit.joint];
  const plane = turning(joint, found[limit.joint + 1], origin(toolOf(found)));
  const seen = pen.project(plane.at);
  if (seen === null) return;
  const radius = Math.max(LEAST_PX, SHARE * pen.size) / seen[2];
  if (joint.slides) drawWay(pen, plane, limit, radius, tone, under);
  else drawArc(pen, plane, limit.way, radius, tone, under);
  pen.text(minus(plane.at, times(plane.toward, LABEL * radius)), gapWords(cell, limit), tone, under);
}

/** @type {(pen: Pen, plane: Plane, way: number, radius: number, tone: string, under: string) => void} */
function drawArc(pen, plane, way, radius, tone, under) {
  const points = arc(plane, way, radius);
  const end = points[points.length - 1];
  const dial = arc({ ...plane, toward: unit(minus(end, plane.at)) }, -Math.sign(way) * DIAL, radius);
  const bar = [0.7, 1.3].map((share) => add(plane.at, times(minus(end, plane.at), share)));
  pen.fill([plane.at, ...dial], tone, 0.22);
  for (const { colour, more } of [{ colour: under, more: 3 }, { colour: tone, more: 0 }]) {
    pen.line(dial, colour, 1.5 + more);
    pen.line([plane.at, points[0]], colour, 2 + more);
    pen.line(points, colour, THICK + more);
    pen.line(bar, colour, 3.5 + more);
    pen.disc(plane.at, colour, 4 + more / 2);
  }
}

/** @type {(pen: Pen, plane: Plane, limit: Limit, radius: number, tone: string, under: string) => void} */
function drawWay(pen, { axis, at, toward }, { way }, radius, tone, under) {
  const end = add(at, times(axis, way));
  const bar = [-0.4, 0.4].map((share) => add(end, times(toward, share * radius)));
  for (const { colour, more } of [{ colour: under, more: 3 }, { colour: tone, more: 0 }]) {
    pen.line([at, end], colour, THICK + more);
    pen.line(bar, colour, 3 + more);
  }
}

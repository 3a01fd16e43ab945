// The drawing of an arm in its cell, from the back to the front: solids where the cell says which, else lines.
/** @import { Box, Cell, Robot, Vector } from "../model/messages.d.ts" */
/** @import { Capsule } from "./arm_solids.js" */
/** @import { Transform } from "./kinematics.js" */
/** @import { Sight } from "./orbit.js" */
import { bones, gripperSolids, placedCapsules } from "./arm_solids.js";
import { drawBack } from "./back_arrow.js";
import { drawCapsule } from "./capsule_shading.js";
import { ordered } from "./depth_order.js";
import { drawFixture, seenFaces } from "./fixtures.js";
import { nearLimits } from "./joint_limits.js";
import { frames, fromPose, origin, toolOf } from "./kinematics.js";
import { drawLimit } from "./limit_arcs.js";
import { Pen } from "./pen.js";
import { PostureOutline } from "./posture_outline.js";
import { drawPlumb, drawShadows, topBelow } from "./shadows.js";

/** @typedef {Record<"measured" | "commanded" | "target" | "box" | "edge" | "holding" | "fault" | "panel" | "text", string>} Tone */
/** @typedef {{ name: string | null, wanted: Vector | null }} Limited */
/** @typedef {Pick<Robot, "q" | "q_commanded" | "target" | "silent" | "gripper">} Drawn */

const AXIS_M = 0.1;
const EDGES = [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]];
const GROUND_M = 0.8;
const THIN = 0.65;
const FADED = 0.4; // what is no longer so

export class ArmDrawing {
  #outline = new PostureOutline();

  /** Draw a cell, and its robot unless that is null, as seen by `sight`; `limited` is the limit's name, and where the hand wants the tool.
   * @type {(context: CanvasRenderingContext2D, sight: Sight, cell: Cell, robot: Drawn | null, limited: Limited, tone: Tone) => void} */
  draw(context, sight, cell, robot, limited, tone) {
    const pen = new Pen(context, sight);
    if (cell.shapes.fixtures.length === 0) drawGround(pen, tone.edge);
    context.globalAlpha = THIN;
    drawBox(pen, cell.workspace_min, cell.workspace_max, tone.box);
    context.globalAlpha = 1;
    const found = robot === null ? null : frames(cell, robot.q);
    const isSolid = cell.shapes.capsules.length > 0;
    const solids = robot !== null && found !== null && isSolid ? armSolids(cell, robot, found) : [];
    const tool = found === null ? null : origin(toolOf(found));
    for (const { capsule, box } of ordered(solids, cell.shapes.fixtures, sight)) {
      if (box) drawBelow(pen, sight, box, cell.shapes.fixtures, solids, tool, tone);
      else if (robot !== null) drawPart(context, sight, capsule, robot, tone);
    }
    if (robot === null || found === null || tool === null) return;
    if (isSolid) this.#outline.draw(context, sight, placedCapsules(cell, frames(cell, robot.q_commanded)), tone.commanded);
    else drawLines(pen, cell, robot, found, tone);
    for (const limit of nearLimits(cell, robot.q).reverse()) {
      drawLimit(pen, cell, limit, found, limit.at ? tone.fault : tone.holding, tone.panel);
    }
    if (robot.target !== null) drawTarget(pen, fromPose(robot.target), tone);
    if (limited.name !== null) drawBack(context, sight.project, tool, limited.wanted, limited.name);
  }
}

/** The capsules of the arm, and its gripper where that is measured: it takes the place of what guards it.
 * @type {(cell: Cell, robot: Drawn, found: Transform[]) => Capsule[]} */
function armSolids(cell, robot, found) {
  const arm = [...bones(found), ...placedCapsules(cell, found)];
  if (robot.gripper === null) return arm;
  return [...arm.filter(({ tool }) => !tool), ...gripperSolids(cell, found, robot.gripper)];
}

/** A fixture, and on its top what shows how high the arm is above it.
 * @type {(pen: Pen, sight: Sight, box: Box, fixtures: Box[], solids: Capsule[], tool: Vector | null, tone: Tone) => void} */
function drawBelow(pen, sight, box, fixtures, solids, tool, tone) {
  drawFixture(pen, box, sight.position, tone.box);
  const top = seenFaces(box, sight.position).find((face) => face.top);
  if (!top) return;
  drawShadows(pen, solids, top.corners);
  if (tool !== null && topBelow(tool, fixtures) === box.upper[2]) drawPlumb(pen, tool, box.upper[2], tone.text);
}

/** @type {(context: CanvasRenderingContext2D, sight: Sight, capsule: Capsule, robot: Drawn, tone: Tone) => void} */
function drawPart(context, sight, capsule, robot, tone) {
  context.globalAlpha = robot.silent ? FADED : 1;
  drawCapsule(context, sight, capsule, capsule.finger ? tone.text : tone.measured, tone.panel);
  context.globalAlpha = 1;
}

/** @type {(pen: Pen, cell: Cell, robot: Drawn, found: Transform[], tone: Tone) => void} */
function drawLines(pen, cell, robot, found, tone) {
  pen.context.globalAlpha = 0.4;
  pen.line(frames(cell, robot.q_commanded).map(origin), tone.commanded, 14);
  pen.context.globalAlpha = robot.silent ? FADED : 1;
  const points = found.map(origin);
  pen.line(points, tone.measured, 7);
  for (const point of points.slice(0, -1)) pen.disc(point, tone.measured, 5);
  drawAxes(pen, toolOf(found), tone.measured, 2);
  pen.context.globalAlpha = 1;
}

/** @type {(pen: Pen, tone: string) => void} */
function drawGround(pen, tone) {
  for (let k = -4; k <= 4; k++) {
    const at = (k / 4) * GROUND_M;
    pen.line([[at, -GROUND_M, 0], [at, GROUND_M, 0]], tone, 1);
    pen.line([[-GROUND_M, at, 0], [GROUND_M, at, 0]], tone, 1);
  }
}

/** @type {(pen: Pen, low: Vector, high: Vector, tone: string) => void} */
function drawBox(pen, low, high, tone) {
  const corners = Array.from({ length: 8 }, (_, k) => [0, 1, 2].map((axis) => ((k >> axis) & 1 ? high[axis] : low[axis])));
  for (const [a, b] of EDGES) pen.line([corners[a], corners[b]], tone, 0.7);
}

/** @type {(pen: Pen, frame: Transform, tone: string, width: number) => void} */
function drawAxes(pen, frame, tone, width) {
  const at = origin(frame);
  for (const axis of [0, 1, 2]) {
    pen.line([at, at.map((v, row) => v + AXIS_M * frame[4 * row + axis])], tone, width);
  }
}

/** @type {(pen: Pen, frame: Transform, tone: Tone) => void} */
function drawTarget(pen, frame, tone) {
  for (const { colour, more } of [{ colour: tone.panel, more: 2 }, { colour: tone.target, more: 0 }]) {
    drawAxes(pen, frame, colour, 2 + more);
    pen.disc(origin(frame), colour, 4 + more / 2);
  }
}

// At a limit, an arrow from the tool to where the hand gets back from it, or the limit's name; on pictures and in the 3D view.
/** @import { Vector } from "../model/messages.d.ts" */
import { letter } from "./letters.js";
import { hasWayBack } from "./limits.js";
import { wayBack } from "./way_back.js";

/** @typedef {(point: Vector) => number[] | null} Where */

const LONG_M = 0.09;
const HEAD = 0.93; // in letters, as the widths below
/** @type {[string, number][]} */
const TONES = [["#000000c0", 0.64], ["#f5b935", 0.36]];

/**
 * Draw the way back from the limit of this name, as the next step has it in words: an arrow to the limit would be read as where to go.
 * `project` gives the canvas's pixel of a point in the base's frame, null where it is not seen.
 * @type {(context: CanvasRenderingContext2D, project: Where, tool: Vector, wanted: Vector | null, name: string) => void}
 */
export function drawBack(context, project, tool, wanted, name) {
  const at = project(tool);
  if (at === null) return;
  const back = hasWayBack(name) ? wayBack(tool, wanted) : null;
  const tip = back === null ? null : project(tool.map((v, axis) => v + LONG_M * back[axis]));
  if (tip !== null) drawArrow(context, at, tip);
  drawWords(context, tip ?? at, tip === null ? name : "back");
}

/** @type {(context: CanvasRenderingContext2D, from: number[], to: number[]) => void} */
function drawArrow(context, from, to) {
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  const head = HEAD * letter();
  /** @type {(turn: number) => [number, number]} */
  const barb = (turn) => [to[0] - head * Math.cos(angle + turn), to[1] - head * Math.sin(angle + turn)];
  context.lineCap = context.lineJoin = "round";
  for (const [tone, width] of TONES) {
    context.strokeStyle = tone;
    context.lineWidth = width * letter();
    context.beginPath();
    context.moveTo(from[0], from[1]);
    context.lineTo(to[0], to[1]);
    context.moveTo(...barb(0.6));
    context.lineTo(to[0], to[1]);
    context.lineTo(...barb(-0.6));
    context.stroke();
  }
}

/** @type {(context: CanvasRenderingContext2D, at: number[], words: string) => void} */
function drawWords(context, [x, y], words) {
  const em = letter();
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.font = `600 ${em}px "DejaVu Sans", system-ui, sans-serif`;
  const { width } = context.measureText(words);
  const isRight = x + width + 1.7 * em > context.canvas.clientWidth;
  const left = Math.max(0.5 * em, isRight ? x - width - 1.4 * em : x + 0.85 * em);
  context.fillStyle = "#000000c0";
  context.beginPath();
  context.roundRect(left - 0.35 * em, y - 1.57 * em, width + 0.7 * em, 1.43 * em, 4);
  context.fill();
  context.fillStyle = "#ffd479";
  context.fillText(words, left, y - 0.5 * em);
}

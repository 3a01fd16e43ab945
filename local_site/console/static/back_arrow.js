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
  const end = back === null ? null : project(tool.map((v, axis) => v + LONG_M * back[axis]));
  if (end === null) return drawWords(context, at, name, false);
  const tip = inPicture(at, end, context.canvas, 0.5 * HEAD * letter());
  drawArrow(context, at, tip);
  drawWords(context, tip, "back", tip[0] < at[0]); // beside the tip, away from the tool's marks
}

/**
 * The point nearest to `to`, on the way there from `from`, that is `margin` within the canvas: an arrow whose head is not seen is a line.
 * @type {(from: number[], to: number[], canvas: { clientWidth: number, clientHeight: number }, margin: number) => number[]}
 */
export function inPicture(from, to, { clientWidth, clientHeight }, margin) {
  const fractions = [clientWidth, clientHeight].map((size, axis) => {
    const way = to[axis] - from[axis];
    const room = (way > 0 ? size - margin : margin) - from[axis];
    return way === 0 ? 1 : Math.max(0, room / way);
  });
  const fraction = Math.min(1, ...fractions);
  return from.map((start, axis) => start + fraction * (to[axis] - start));
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

/** @type {(context: CanvasRenderingContext2D, at: number[], words: string, toLeft: boolean) => void} */
function drawWords(context, [x, y], words, toLeft) {
  const em = letter();
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
  context.font = `600 ${em}px "DejaVu Sans", system-ui, sans-serif`;
  const { width } = context.measureText(words);
  const [toTheLeft, toTheRight] = [x - width - 1.4 * em, x + 0.85 * em];
  const isLeft = toLeft ? toTheLeft >= 0.5 * em : toTheRight + width + 0.85 * em > context.canvas.clientWidth;
  const left = Math.max(0.5 * em, isLeft ? toTheLeft : toTheRight);
  const baseline = Math.max(y - 0.5 * em, 1.1 * em); // within the picture, at its upper edge too
  context.fillStyle = "#000000c0";
  context.beginPath();
  context.roundRect(left - 0.35 * em, baseline - 1.07 * em, width + 0.7 * em, 1.43 * em, 4);
  context.fill();
  context.fillStyle = "#ffd479";
  context.fillText(words, left, baseline);
}

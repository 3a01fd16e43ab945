// An arrow from the tool to where the hand pushes against a limit, with the limit's name; on pictures and in the 3D view.
import { distance } from "./kinematics.js";

const LONG_M = 0.09;
const LEAST_PUSH_M = 0.004; // a limit of the orientation alone has no direction
const HEAD_PX = 13;
const TONES = [["#000000c0", 9], ["#f5b935", 5]];

/** The arrow's tip (m) for a tool and where the hand wants it; null where the hand pushes in no direction. */
export function pushOf(tool, wanted) {
  const push = distance(tool, wanted);
  return push < LEAST_PUSH_M ? null : tool.map((v, axis) => v + (LONG_M * (wanted[axis] - v)) / push);
}

/** Draw the push at a place of the base's frame; `project` gives the canvas's pixel of a point, null where it is not seen. */
export function drawPushAt(context, project, tool, wanted, name) {
  const at = project(tool);
  const tip = wanted === null ? null : pushOf(tool, wanted);
  if (at !== null) drawPush(context, at, tip === null ? null : project(tip), name);
}

/** Draw it between two pixels, and the name beside its tip; without a tip only the name, at the tool. */
export function drawPush(context, at, tip, name) {
  if (tip !== null) drawArrow(context, at, tip);
  drawName(context, tip ?? at, name);
}

function drawArrow(context, from, to) {
  const angle = Math.atan2(to[1] - from[1], to[0] - from[0]);
  const barb = (turn) => [to[0] - HEAD_PX * Math.cos(angle + turn), to[1] - HEAD_PX * Math.sin(angle + turn)];
  context.lineCap = context.lineJoin = "round";
  for (const [tone, width] of TONES) {
    context.strokeStyle = tone;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(...from);
    context.lineTo(...to);
    context.moveTo(...barb(0.6));
    context.lineTo(...to);
    context.lineTo(...barb(-0.6));
    context.stroke();
  }
}

function drawName(context, [x, y], name) {
  context.font = "600 14px 'DejaVu Sans', system-ui, sans-serif";
  const { width } = context.measureText(name);
  const isRight = x + width + 24 > context.canvas.clientWidth;
  const left = isRight ? x - width - 20 : x + 12;
  context.fillStyle = "#000000c0";
  context.beginPath();
  context.roundRect(left - 5, y - 22, width + 10, 20, 4);
  context.fill();
  context.fillStyle = "#ffd479";
  context.fillText(name, left, y - 7);
}

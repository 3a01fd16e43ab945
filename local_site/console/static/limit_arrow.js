// An arrow from the tool to where the hand pushes against a limit, with the limit's name; on pictures and in the 3D view.
import { distance } from "./kinematics.js";

const LONG_M = 0.09;
const LEAST_PUSH_M = 0.004; // a limit of the orientation alone has no direction
const HEAD_PX = 13;
const TONES = [["#000000c0", 9], ["#f5b935", 5]];

/** Draw the push against a limit; `project` gives the canvas's pixel of a point in the base's frame, null where it is not seen. */
export function drawPush(context, project, tool, wanted, name) {
  const at = project(tool);
  if (at === null) return;
  const towards = wanted === null ? null : pushOf(tool, wanted);
  const tip = towards === null ? null : project(towards);
  if (tip !== null) drawArrow(context, at, tip);
  drawName(context, tip ?? at, name);
}

/** The arrow's tip (m) for a tool and where the hand wants it; null where the hand pushes in no direction. */
function pushOf(tool, wanted) {
  const push = distance(tool, wanted);
  return push < LEAST_PUSH_M ? null : tool.map((v, axis) => v + (LONG_M * (wanted[axis] - v)) / push);
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
  context.textAlign = "left";
  context.textBaseline = "alphabetic";
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

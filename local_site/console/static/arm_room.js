// The 3D view: the arm as measured, the ghost of what is commanded, the hand's target, and the workspace.
import { distance, frames, fromPose, origin } from "./kinematics.js";
import { Orbit } from "./orbit.js";
import { sized, tones } from "./surface.js";
import { put } from "./words.js";

const AXIS_M = 0.08;
const EDGES = [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]];
const GROUND_M = 0.8;

export class ArmRoom {
  #canvas = document.getElementById("arm");
  #words = document.getElementById("arm-words");
  #context = this.#canvas.getContext("2d");
  #orbit = new Orbit(this.#canvas, () => this.#ask());
  #cell = null;
  #robot = null;
  #asked = null;

  constructor() {
    new ResizeObserver(() => this.#ask()).observe(this.#canvas);
  }

  /** Draw again in the page's colours, which have changed. */
  repaint() {
    this.#ask();
  }

  describe(cell) {
    this.#cell = cell;
    this.#orbit.show(cell.workspace_min, cell.workspace_max);
    this.#ask();
  }

  show(robot) {
    this.#robot = robot;
    if (this.#cell !== null && robot !== null) this.#describe();
    this.#ask();
  }

  #ask() {
    this.#asked ??= requestAnimationFrame(() => {
      this.#asked = null;
      this.#draw();
    });
  }

  #describe() {
    const robot = this.#robot;
    const tool = origin(frames(this.#cell, robot.q).at(-1));
    const words = [`tool at ${tool.map((v) => (v * 1000).toFixed(0)).join(", ")} mm`];
    if (robot.target !== null) words.push(`hand's target ${(1000 * distance(robot.target.position, tool)).toFixed(0)} mm away`);
    if (robot.min_distance !== null) words.push(`nearest ${(robot.min_distance * 1000).toFixed(0)} mm`);
    if (robot.silent) words.push("last state received: the remote site is silent");
    put(this.#words, words.join(" · "));
  }

  #draw() {
    const { width, height } = sized(this.#canvas, this.#context);
    this.#context.clearRect(0, 0, width, height);
    const cell = this.#cell;
    if (cell === null) return;
    const tone = tones("measured", "commanded", "target", "box", "edge");
    const pen = new Pen(this.#context, this.#orbit.projection(width, height));
    drawGround(pen, tone.edge);
    drawBox(pen, cell.workspace_min, cell.workspace_max, tone.box);
    if (this.#robot === null) return;
    this.#context.globalAlpha = 0.4;
    pen.line(frames(cell, this.#robot.q_commanded).map(origin), tone.commanded, 14);
    this.#context.globalAlpha = this.#robot.silent ? 0.4 : 1;
    drawArm(pen, frames(cell, this.#robot.q), tone.measured, 7);
    if (this.#robot.target !== null) drawTarget(pen, fromPose(this.#robot.target), tone.target);
    this.#context.globalAlpha = 1;
  }
}

class Pen {
  constructor(context, project) {
    this.context = context;
    this.project = project;
  }

  line(points, tone, width) {
    const seen = points.map(this.project);
    if (seen.includes(null)) return;
    this.context.strokeStyle = tone;
    this.context.lineWidth = width;
    this.context.lineCap = this.context.lineJoin = "round";
    this.context.beginPath();
    seen.forEach(([x, y], k) => (k === 0 ? this.context.moveTo(x, y) : this.context.lineTo(x, y)));
    this.context.stroke();
  }

  disc(point, tone, radius) {
    const seen = this.project(point);
    if (seen === null) return;
    this.context.fillStyle = tone;
    this.context.beginPath();
    this.context.arc(seen[0], seen[1], radius, 0, 2 * Math.PI);
    this.context.fill();
  }
}

function drawGround(pen, tone) {
  for (let k = -4; k <= 4; k++) {
    const at = (k / 4) * GROUND_M;
    pen.line([[at, -GROUND_M, 0], [at, GROUND_M, 0]], tone, 1);
    pen.line([[-GROUND_M, at, 0], [GROUND_M, at, 0]], tone, 1);
  }
}

function drawBox(pen, low, high, tone) {
  const corners = Array.from({ length: 8 }, (_, k) => [0, 1, 2].map((axis) => ((k >> axis) & 1 ? high[axis] : low[axis])));
  for (const [a, b] of EDGES) pen.line([corners[a], corners[b]], tone, 1.2);
}

function drawArm(pen, found, tone, width) {
  const points = found.map(origin);
  pen.line(points, tone, width);
  for (const point of points.slice(0, -1)) pen.disc(point, tone, 0.7 * width);
  drawAxes(pen, found.at(-1), tone, 2);
}

function drawAxes(pen, frame, tone, width) {
  const at = origin(frame);
  for (const axis of [0, 1, 2]) {
    pen.line([at, at.map((v, row) => v + AXIS_M * frame[4 * row + axis])], tone, width);
  }
}

function drawTarget(pen, frame, tone) {
  drawAxes(pen, frame, tone, 3);
  pen.disc(origin(frame), tone, 6);
}

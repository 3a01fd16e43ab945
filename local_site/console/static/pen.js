// Lines, discs and areas on a canvas, given as points in the base's frame (m).
/** @import { Vector } from "../model/messages.d.ts" */
/** @import { Project, Sight } from "./orbit.js" */
import { letter } from "./letters.js";

/** @typedef {string | CanvasGradient} Paint */

const FONT = 'px "DejaVu Sans", system-ui, sans-serif';

export class Pen {
  /** `sight` projects, and knows the canvas's shorter side in pixels (`orbit.js`).
   * @param {CanvasRenderingContext2D} context @param {Sight} sight */
  constructor(context, sight) {
    this.context = context;
    /** @type {Project} */
    this.project = sight.project;
    this.size = sight.size;
  }

  /** @type {(points: Vector[], tone: Paint, width: number) => void} */
  line(points, tone, width) {
    if (!this.trace(points)) return;
    this.context.strokeStyle = tone;
    this.context.lineWidth = width;
    this.context.lineCap = this.context.lineJoin = "round";
    this.context.stroke();
  }

  /** @type {(points: Vector[], tone: Paint, alpha: number) => void} */
  fill(points, tone, alpha) {
    if (!this.trace(points)) return;
    const { globalAlpha } = this.context;
    this.context.fillStyle = tone;
    this.context.globalAlpha = globalAlpha * alpha;
    this.context.fill();
    this.context.globalAlpha = globalAlpha;
  }

  /** @type {(point: Vector, tone: Paint, radius: number) => void} */
  disc(point, tone, radius) {
    const seen = this.project(point);
    if (seen === null) return;
    this.context.fillStyle = tone;
    this.context.beginPath();
    this.context.arc(seen[0], seen[1], radius, 0, 2 * Math.PI);
    this.context.fill();
  }

  /** @type {(point: Vector, words: string, tone: Paint, under: Paint) => void} */
  text(point, words, tone, under) {
    const seen = this.project(point);
    if (seen === null) return;
    this.context.font = `700 ${0.93 * letter()}${FONT}`;
    this.context.textAlign = "center";
    this.context.textBaseline = "middle";
    this.context.lineJoin = "round";
    this.context.lineWidth = 4;
    this.context.strokeStyle = under;
    this.context.strokeText(words, seen[0], seen[1]);
    this.context.fillStyle = tone;
    this.context.fillText(words, seen[0], seen[1]);
  }

  /** Begin a path through points; false where one is behind the eye.
   * @type {(points: Vector[]) => boolean} */
  trace(points) {
    this.context.beginPath();
    return this.append(points);
  }

  /** Add points to the path; false where one is behind the eye.
   * @type {(points: Vector[]) => boolean} */
  append(points) {
    const seen = points.map(this.project);
    if (!seen.every((one) => one !== null)) return false;
    seen.forEach(([x, y], k) => (k === 0 ? this.context.moveTo(x, y) : this.context.lineTo(x, y)));
    return true;
  }
}

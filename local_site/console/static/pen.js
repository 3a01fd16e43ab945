// Lines, discs and areas on a canvas, given as points in the base's frame (m).
import { letter } from "./letters.js";

const FONT = 'px "DejaVu Sans", system-ui, sans-serif';

export class Pen {
  /** `sight` projects, and knows the canvas's shorter side in pixels (`orbit.js`). */
  constructor(context, sight) {
    this.context = context;
    this.project = sight.project;
    this.size = sight.size;
  }

  line(points, tone, width) {
    if (!this.trace(points)) return;
    this.context.strokeStyle = tone;
    this.context.lineWidth = width;
    this.context.lineCap = this.context.lineJoin = "round";
    this.context.stroke();
  }

  fill(points, tone, alpha) {
    if (!this.trace(points)) return;
    const { globalAlpha } = this.context;
    this.context.fillStyle = tone;
    this.context.globalAlpha = globalAlpha * alpha;
    this.context.fill();
    this.context.globalAlpha = globalAlpha;
  }

  disc(point, tone, radius) {
    const seen = this.project(point);
    if (seen === null) return;
    this.context.fillStyle = tone;
    this.context.beginPath();
    this.context.arc(seen[0], seen[1], radius, 0, 2 * Math.PI);
    this.context.fill();
  }

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

  /** Begin a path through points; false where one is behind the eye. */
  trace(points) {
    this.context.beginPath();
    return this.append(points);
  }

  /** Add points to the path; false where one is behind the eye. */
  append(points) {
    const seen = points.map(this.project);
    if (seen.includes(null)) return false;
    seen.forEach(([x, y], k) => (k === 0 ? this.context.moveTo(x, y) : this.context.lineTo(x, y)));
    return true;
  }
}

// The eye of the 3D view: turned by mouse, touch or arrow keys; where it sees a point on the canvas.
/** @import { Vector } from "../model/messages.d.ts" */
import { add, cross, dot, minus, times } from "./vectors.js";

/** @typedef {[number, number, number]} Seen x, y, and how many pixels a metre has there */
/** @typedef {(point: Vector) => Seen | null} Project */
/** @typedef {{ position: Vector, right: Vector, up: Vector, toward: Vector }} Eye */
/** @typedef {Eye & { size: number, project: Project }} Sight */
/** @typedef {{ scale: number, x: number, y: number }} Frame */

const STEP = 0.12;
const ZOOM = 1.1;
const ROOM = 1.55; // distance of the eye relative to the size of the scene
const [YAW, PITCH] = [-0.9, 0.35];
const MARGIN_PX = 5;
const INNER = 0.07; // of the box on each side may be out of sight: a tool is seldom in a corner
const BASE = [[-0.1, -0.1, 0], [0.1, -0.1, 0]]; // m: where an arm stands
const NEAREST_M = 0.05;

export class Orbit {
  #yaw = YAW;
  #pitch = PITCH;
  #distance = 2.3;
  #home = 2.3;
  #center = [0.25, 0, 0.45];
  /** @type {Vector[]} */
  #framed = [];
  #known = false;

  /** @param {HTMLCanvasElement} canvas @param {() => void} changed */
  constructor(canvas, changed) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      this.#turn(-event.movementX * 0.008, event.movementY * 0.008);
      changed();
    });
    canvas.addEventListener("wheel", (event) => {
      if (document.activeElement !== canvas) return; // the page scrolls
      event.preventDefault();
      this.#zoom(event.deltaY > 0 ? ZOOM : 1 / ZOOM);
      changed();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event) && (event.preventDefault(), changed()));
  }

  /** Frame a box (m) and the base, the first time that it is known.
   * @type {(low: Vector, high: Vector) => void} */
  show(low, high) {
    if (this.#known) return;
    this.#known = true;
    const [from, to] = [low.map((v) => Math.min(v, 0)), high.map((v) => Math.max(v, 0))];
    this.#center = from.map((v, axis) => (v + to[axis]) / 2);
    this.#home = this.#distance = ROOM * Math.hypot(...from.map((v, axis) => to[axis] - v));
    const [near, far] = [INNER, 1 - INNER].map((share) => low.map((v, axis) => v + share * (high[axis] - v)));
    const corners = Array.from({ length: 8 }, (_, k) => near.map((v, axis) => ((k >> axis) & 1 ? far[axis] : v)));
    this.#framed = [...corners, ...BASE];
  }

  /** @type {(event: KeyboardEvent) => boolean} */
  #key({ key }) {
    /** @type {Record<string, () => void>} */
    const acts = {
      ArrowLeft: () => this.#turn(-STEP, 0),
      ArrowRight: () => this.#turn(STEP, 0),
      ArrowUp: () => this.#turn(0, STEP),
      ArrowDown: () => this.#turn(0, -STEP),
      "+": () => this.#zoom(1 / ZOOM),
      "-": () => this.#zoom(ZOOM),
    };
    acts[key]?.();
    return key in acts;
  }

  /** @type {(yaw: number, pitch: number) => void} */
  #turn(yaw, pitch) {
    this.#yaw += yaw;
    this.#pitch = Math.min(1.5, Math.max(-0.3, this.#pitch + pitch));
  }

  /** @type {(factor: number) => void} */
  #zoom(factor) {
    this.#distance = Math.min(8, Math.max(0.8, this.#distance * factor));
  }

  /** How a canvas of this size is seen: `project`, its shorter side, and the eye's place and axes in the base's frame.
   * @type {(width: number, height: number) => Sight} */
  sight(width, height) {
    const eye = eyeAt(this.#yaw, this.#pitch, this.#distance, this.#center);
    const frame = fitted(eyeAt(YAW, PITCH, this.#home, this.#center), this.#framed, width, height);
    return { ...eye, size: Math.min(width, height), project: (point) => projected(eye, frame, point) };
  }
}

/** An eye that looks at a centre from a distance: its position (m), and unit vectors right, up, and toward it.
 * @type {(yaw: number, pitch: number, distance: number, center: Vector) => Eye} */
export function eyeAt(yaw, pitch, distance, center) {
  const toward = [Math.cos(pitch) * Math.cos(yaw), Math.cos(pitch) * Math.sin(yaw), Math.sin(pitch)];
  const right = [-Math.sin(yaw), Math.cos(yaw), 0];
  return { position: add(center, times(toward, distance)), toward, right, up: cross(toward, right) };
}

/** The scale (pixels of a metre at a metre's distance) and the canvas's point straight ahead that just show all points.
 * @type {(eye: Eye, points: Vector[], width: number, height: number) => Frame} */
export function fitted(eye, points, width, height) {
  if (points.length === 0) return { scale: 1.7 * Math.min(width, height), x: width / 2, y: height / 2 };
  const seen = points.map((point) => inEyesFrame(eye, point)).map(([across, high, depth]) => [across / depth, -high / depth]);
  const [[left, right], [top, bottom]] = [0, 1].map((k) => [Math.min(...seen.map((p) => p[k])), Math.max(...seen.map((p) => p[k]))]);
  const scale = Math.max(Math.min((width - 2 * MARGIN_PX) / (right - left), (height - 2 * MARGIN_PX) / (bottom - top)), 1);
  return { scale, x: width / 2 - (scale * (left + right)) / 2, y: height / 2 - (scale * (top + bottom)) / 2 };
}

/** [x, y, pixels of a metre there] of a point in the base's frame (m); null behind the eye.
 * @type {(eye: Eye, frame: Frame, point: Vector) => Seen | null} */
function projected(eye, { scale, x, y }, point) {
  const [across, high, depth] = inEyesFrame(eye, point);
  if (depth < NEAREST_M) return null;
  return [x + (scale * across) / depth, y - (scale * high) / depth, scale / depth];
}

/** @type {(eye: Eye, point: Vector) => [number, number, number]} */
function inEyesFrame({ position, right, up, toward }, point) {
  const away = minus(point, position);
  return [dot(away, right), dot(away, up), -dot(away, toward)];
}

// The 3D view: when the arm is drawn, from where, and the words below it.
/** @import { Cell, Robot, Vector } from "../model/messages.d.ts" */
/** @import { Limited, Tone } from "./arm_drawing.js" */
import { ArmDrawing } from "./arm_drawing.js";
import { element, tagged } from "./elements.js";
import { limitWords } from "./joint_limits.js";
import { frames, origin, toolOf } from "./kinematics.js";
import { Orbit } from "./orbit.js";
import { LastDrawn, sized, tones } from "./surface.js";
import { put } from "./words.js";

const STEP = 0.001; // rad and m: less is not seen
/** @type {(keyof Tone)[]} */
const TONES = ["measured", "commanded", "target", "box", "edge", "holding", "fault", "panel", "text"];

export class ArmRoom {
  #canvas = tagged("canvas", "arm");
  #words = element("arm-words");
  #context = /** @type {CanvasRenderingContext2D} */ (this.#canvas.getContext("2d"));
  #orbit = new Orbit(this.#canvas, () => this.#ask());
  #drawing = new ArmDrawing();
  /** @type {Cell | null} */
  #cell = null;
  /** @type {Robot | null} */
  #robot = null;
  /** @type {Limited} */
  #limit = { name: null, wanted: null };
  /** @type {number | null} */
  #asked = null;
  #last = new LastDrawn(STEP);

  constructor() {
    new ResizeObserver(() => this.#ask()).observe(this.#canvas);
  }

  /** Draw again in the page's colours, which have changed. */
  repaint() {
    this.#ask();
  }

  /** @type {(cell: Cell) => void} */
  describe(cell) {
    this.#cell = cell;
    this.#orbit.show(cell.workspace_min, cell.workspace_max);
    this.#ask();
  }

  /** @type {(robot: Robot | null) => void} */
  show(robot) {
    this.#robot = robot;
  }

  /** Draw what has changed since the last time. */
  refresh() {
    if (document.hidden) return;
    const robot = this.#shown;
    const limit = this.#limit.name === null ? null : this.#limit;
    if (this.#last.differs(robot === null ? null : seenOf(robot), limit)) this.#draw();
  }

  /** The name of the limit that keeps the arm from following, null while none does.
   * @type {(name: string | null) => void} */
  showLimit(name) {
    this.#limit = { ...this.#limit, name };
  }

  /** Where the hand wants the tool (m), null where that is not known.
   * @type {(wanted: Vector | null) => void} */
  want(wanted) {
    this.#limit = { ...this.#limit, wanted };
  }

  /** The robot, unless its state is still of another arm than the one described last. */
  get #shown() {
    return this.#robot?.q.length === this.#cell?.joints.length ? this.#robot : null;
  }

  #ask() {
    this.#asked ??= requestAnimationFrame(() => {
      this.#asked = null;
      this.#draw();
    });
  }

  /** Say where the arm is, in figures. */
  tell() {
    if (this.#cell !== null && this.#shown !== null && !document.hidden) this.#describe(this.#cell, this.#shown);
  }

  /** @type {(cell: Cell, robot: Robot) => void} */
  #describe(cell, robot) {
    const tool = origin(toolOf(frames(cell, robot.q)));
    const words = [limitWords(cell, robot.q), `tool at ${tool.map((v) => (v * 1000).toFixed(0)).join(", ")} mm`];
    if (robot.min_distance !== null) words.push(`nearest obstacle ${(robot.min_distance * 1000).toFixed(0)} mm`);
    if (robot.silent) words.push("last state received: the remote site is silent");
    put(this.#words, words.filter(Boolean).join(" · "));
  }

  #draw() {
    const { width, height } = sized(this.#canvas, this.#context);
    this.#context.clearRect(0, 0, width, height);
    if (this.#cell === null || width === 0) return; // not shown until an arm is known
    this.#drawing.draw(this.#context, this.#orbit.sight(width, height), this.#cell, this.#shown, this.#limit, tones(...TONES));
  }
}

/** What the drawing shows of a robot.
 * @type {(robot: Robot) => unknown} */
function seenOf({ q, q_commanded, target, silent, gripper }) {
  return { q, q_commanded, target, silent, opening: gripper && gripper.opening };
}

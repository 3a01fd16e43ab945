// The 3D view: when the arm is drawn, from where, and the words below it.
import { ArmDrawing } from "./arm_drawing.js";
import { limitWords } from "./joint_limits.js";
import { frames, origin } from "./kinematics.js";
import { Orbit } from "./orbit.js";
import { LastDrawn, sized, tones } from "./surface.js";
import { READ_MS, put } from "./words.js";

const STEP = 0.001; // rad and m: less is not seen
const TONES = ["measured", "commanded", "target", "box", "edge", "holding", "fault", "panel", "text"];

export class ArmRoom {
  #canvas = document.getElementById("arm");
  #words = document.getElementById("arm-words");
  #context = this.#canvas.getContext("2d");
  #orbit = new Orbit(this.#canvas, () => this.#ask());
  #drawing = new ArmDrawing();
  #cell = null;
  #robot = null;
  #limit = { name: null, wanted: null };
  #asked = null;
  #describedMs = -Infinity;
  #last = new LastDrawn(STEP);

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
  }

  /** Draw and describe what has changed since the last time. */
  refresh() {
    if (document.hidden) return;
    const robot = this.#shown;
    if (robot !== null && performance.now() - this.#describedMs >= READ_MS) this.#describe(robot);
    const limit = this.#limit.name === null ? null : this.#limit;
    if (this.#last.differs(robot === null ? null : seenOf(robot), limit)) this.#draw();
  }

  /** The name of the limit that keeps the arm from following, null while none does. */
  showLimit(name) {
    this.#limit = { ...this.#limit, name };
  }

  /** Where the hand wants the tool (m), null where that is not known. */
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

  #describe(robot) {
    this.#describedMs = performance.now();
    const tool = origin(frames(this.#cell, robot.q).at(-1));
    const words = [limitWords(this.#cell, robot.q), `tool at ${tool.map((v) => (v * 1000).toFixed(0)).join(", ")} mm`];
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

/** What the drawing shows of a robot. */
function seenOf({ q, q_commanded, target, silent, gripper }) {
  return { q, q_commanded, target, silent, opening: gripper && gripper.opening };
}

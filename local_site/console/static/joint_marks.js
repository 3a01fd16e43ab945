// Marking the joints in the operator's picture, for a tracker of one camera: by clicks, or by arrow keys and Enter.
/** @import { Connection } from "./connection.js" */
/** @import { View } from "./view.js" */
import { element, tagged } from "./elements.js";
import { pressByKey } from "./keys.js";
import { sized } from "./surface.js";
import { put } from "./words.js";

const JOINTS = ["shoulder", "elbow", "wrist"];
const STEP = 0.01; // of the picture; a fifth of it with the shift key
/** @type {Record<string, number[]>} */
const ARROWS = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP] };
const MIDDLE = [0.5, 0.5];
const TONE = "#ffd479";

export class JointMarks {
  #connection;
  #view;
  #context;
  #row = element("joints-row");
  #button = tagged("button", "joints");
  #words = element("joints-words");
  /** @type {number[][] | null} */
  #marks = null;
  #at = MIDDLE;

  /** `view` is a view of the operator: its element, its picture and the overlay to draw on.
   * @param {Connection} connection @param {View} view */
  constructor(connection, view) {
    this.#connection = connection;
    this.#view = view;
    this.#context = /** @type {CanvasRenderingContext2D} */ (view.overlay.getContext("2d"));
    this.#button.addEventListener("click", () => this.#toggle());
    view.element.addEventListener("click", (event) => this.#click(event));
    pressByKey({ j: this.#button });
    addEventListener("keydown", (event) => this.#key(event));
  }

  /** Offer marking; it is wanted only where a single camera sees the operator.
   * @type {(isWanted: boolean) => void} */
  offer(isWanted) {
    this.#row.hidden = !isWanted;
    if (!isWanted && this.#marks !== null) this.#toggle();
  }

  #toggle() {
    this.#marks = this.#marks === null ? [] : null;
    this.#at = MIDDLE;
    this.#button.setAttribute("aria-pressed", String(this.#marks !== null));
    this.#show();
  }

  /** @type {(event: MouseEvent) => void} */
  #click(event) {
    if (this.#marks === null || event.detail === 0) return; // a click by a key has no position
    const { left, top, width, height } = this.#view.picture.getBoundingClientRect();
    const { across, down, wide, tall } = this.#layout(width, height);
    this.#set(this.#marks, [(event.clientX - left - across) / wide, (event.clientY - top - down) / tall]);
  }

  /** @type {(event: KeyboardEvent) => void} */
  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (this.#marks === null) return;
    const arrow = ARROWS[event.key];
    if (arrow === undefined && event.key !== "Enter") return;
    event.preventDefault();
    if (arrow === undefined) this.#set(this.#marks, this.#at);
    else this.#at = this.#at.map((v, axis) => Math.min(1, Math.max(0, v + arrow[axis] * (event.shiftKey ? 0.2 : 1))));
    this.#show();
  }

  /** Take a position, if it is in the picture; after the last joint all are sent.
   * @type {(marks: number[][], position: number[]) => void} */
  #set(marks, position) {
    if (position.some((v) => !(v >= 0 && v <= 1))) return;
    marks.push(position);
    if (marks.length === JOINTS.length) {
      const [shoulder, elbow, wrist] = marks;
      this.#connection.ask({ type: "mark_joints", shoulder, elbow, wrist });
      this.#toggle();
    }
    this.#show();
  }

  #show() {
    const marks = this.#marks;
    put(this.#words, marks !== null ? `click the ${JOINTS[marks.length]}, or move the cross with arrow keys and press Enter` : "");
    const { width, height } = sized(this.#view.overlay, this.#context);
    this.#context.clearRect(0, 0, width, height);
    if (marks === null) return;
    const { across, down, wide, tall } = this.#layout(width, height);
    /** @type {(position: number[]) => [number, number]} */
    const seen = ([u, v]) => [across + u * wide, down + v * tall];
    this.#context.strokeStyle = this.#context.fillStyle = TONE;
    this.#context.lineWidth = 2;
    this.#context.beginPath();
    const [x, y] = seen(this.#at);
    for (const [dx, dy] of [[9, 0], [0, 9]]) {
      this.#context.moveTo(x - dx, y - dy);
      this.#context.lineTo(x + dx, y + dy);
    }
    marks.map(seen).forEach(([u, v], k) => this.#context[k === 0 ? "moveTo" : "lineTo"](u, v));
    this.#context.stroke();
    for (const [u, v] of marks.map(seen)) this.#context.fillRect(u - 3, v - 3, 6, 6);
  }

  /** The picture's offset and size in its canvas, which it fills in one direction.
   * @type {(width: number, height: number) => { across: number, down: number, wide: number, tall: number }} */
  #layout(width, height) {
    const [wide, tall] = [Math.min(width, height * this.#view.aspect), Math.min(height, width / this.#view.aspect)];
    return { across: (width - wide) / 2, down: (height - tall) / 2, wide, tall };
  }
}

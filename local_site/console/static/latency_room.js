// Latencies: a graph of the last minute, the figures beside it, and the stages of one sample.
/** @import { Figures, Interval, Situation, Trace } from "../model/messages.d.ts" */
import { element, tagged } from "./elements.js";
import { letter } from "./letters.js";
import { sized, tones } from "./surface.js";
import { put } from "./words.js";

/** @typedef {[number, number | null]} Point time and value, null where there is none */

const MINUTE_MS = 60_000;
/** @type {Record<Interval, [string, string]>} */
const INTERVALS = {
  command: ["exposure → command", "accent"],
  motion: ["command → motion", "commanded"],
  encoder: ["command → encoder", "encoder"],
  picture: ["glass to glass", "engaged"],
  hand_to_eye: ["hand to eye", "holding"],
  round_trip: ["round trip", "idle"],
  uncertainty: ["clock uncertainty", "fault"],
};
/** @type {[Exclude<keyof Trace, "seq">, word: string, tone: string][]} */
const STAGES = [
  ["command_ms", "command", "accent"],
  ["motion_ms", "robot", "commanded"],
  ["encoder_ms", "encoder", "encoder"],
  ["exposed_ms", "picture taken", "idle"],
  ["shown_ms", "painted", "engaged"],
];

export class LatencyRoom {
  #canvas = tagged("canvas", "latency");
  #context = /** @type {CanvasRenderingContext2D} */ (this.#canvas.getContext("2d"));
  #trace = element("trace");
  #bar = element("trace-bar");
  /** @type {Map<string, HTMLElement[]>} */
  #cells = new Map();
  /** @type {Map<string, Point[]>} */
  #points = new Map(Object.keys(INTERVALS).map((name) => [name, []]));
  /** @type {number[]} */
  #highest = [];

  constructor() {
    const body = element("latency-figures");
    for (const [name, [label, tone]] of Object.entries(INTERVALS)) body.append(this.#row(name, label, tone));
  }

  /** @type {(name: string, label: string, tone: string) => HTMLElement} */
  #row(name, label, tone) {
    const row = document.createElement("tr");
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = label;
    head.style.setProperty("--tone", `var(--${tone})`);
    const cells = ["newest", "p50", "p95"].map(() => document.createElement("td"));
    row.dataset.interval = name;
    row.append(head, ...cells);
    this.#cells.set(name, cells);
    return row;
  }

  /** @type {(situation: Situation) => void} */
  show({ now_ms: nowMs, latency, trace }) {
    for (const [name, figures] of Object.entries(latency)) this.#note(name, figures, nowMs);
    this.#highest = Object.values(latency).map((figures) => figures.p95 ?? 0); // rarer values are clipped
    this.#draw(nowMs);
    if (trace !== null) this.#follow(trace);
  }

  /** @type {(name: string, figures: Figures, nowMs: number) => void} */
  #note(name, figures, nowMs) {
    this.#cells.get(name)?.forEach((cell, k) => {
      const value = [figures.newest, figures.p50, figures.p95][k];
      put(cell, value === null ? "–" : value.toFixed(value < 10 ? 1 : 0));
    });
    const points = this.#points.get(name) ?? [];
    points.push([nowMs, figures.newest]);
    while (points[0][0] < nowMs - MINUTE_MS) points.shift();
  }

  /** @type {(trace: Trace) => void} */
  #follow(trace) {
    put(this.#trace, traceWords(trace));
    const ends = STAGES.map(([name]) => trace[name]);
    if (this.#bar.children.length === 0) this.#bar.append(...STAGES.map(([, , tone]) => barSegment(tone)));
    ends.forEach((end, k) => {
      const segment = /** @type {HTMLElement} */ (this.#bar.children[k]);
      segment.style.setProperty("flex-grow", String(Math.max(0, end - (ends[k - 1] ?? 0))));
    });
  }

  /** @type {(nowMs: number) => void} */
  #draw(nowMs) {
    const { width, height } = sized(this.#canvas, this.#context);
    if (width === 0) return; // folded away
    const tone = tones("edge", "faint", ...Object.values(INTERVALS).map(([, name]) => name));
    const most = niceCeiling(Math.max(10, ...this.#highest));
    this.#context.clearRect(0, 0, width, height);
    this.#scale(width, height, most, tone);
    for (const [name, [, colour]] of Object.entries(INTERVALS)) {
      this.#line(this.#points.get(name) ?? [], (t, value) => [
        width * (1 - (nowMs - t) / MINUTE_MS), height - 2 - Math.min(1, value / most) * (height - letter()),
      ], tone[colour]);
    }
  }

  /** @type {(width: number, height: number, most: number, tone: Record<string, string>) => void} */
  #scale(width, height, most, tone) {
    this.#context.fillStyle = tone.faint;
    this.#context.strokeStyle = tone.edge;
    this.#context.lineWidth = 1;
    this.#context.font = `${0.86 * letter()}px sans-serif`;
    const top = Math.round(letter());
    this.#context.fillText(`${most} ms`, 2, top - 3);
    this.#context.strokeRect(0.5, top - 0.5, width - 1, height - top);
  }

  /** @type {(points: Point[], toCanvas: (t: number, value: number) => [number, number], tone: string) => void} */
  #line(points, toCanvas, tone) {
    this.#context.strokeStyle = tone;
    this.#context.lineWidth = 1.5;
    this.#context.beginPath();
    let broken = true;
    for (const [t, value] of points) {
      if (value !== null) this.#context[broken ? "moveTo" : "lineTo"](...toCanvas(t, value));
      broken = value === null;
    }
    this.#context.stroke();
  }
}

/** @type {(value: number) => number} */
function niceCeiling(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= value) ?? value;
}

/** @type {(tone: string) => HTMLElement} */
function barSegment(tone) {
  const segment = document.createElement("span");
  segment.style.setProperty("--tone", `var(--${tone})`);
  return segment;
}

/** One sample's path in words, each stage in ms after the hand's exposure.
 * @type {(trace: Trace) => string} */
function traceWords(trace) {
  const words = STAGES.map(([name, word]) => `${word} ${trace[name].toFixed(0)}`);
  return `sample ${trace.seq}, ms after exposure: ${words.join(", ")}`;
}

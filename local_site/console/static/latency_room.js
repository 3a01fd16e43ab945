// Latencies: a graph of the last minute, the figures beside it, and the stages of one sample.
import { letter } from "./letters.js";
import { sized, tones } from "./surface.js";
import { put } from "./words.js";

const MINUTE_MS = 60_000;
const INTERVALS = {
  command: ["exposure → command", "accent"],
  motion: ["command → motion", "commanded"],
  encoder: ["command → encoder", "encoder"],
  picture: ["glass to glass", "engaged"],
  hand_to_eye: ["hand to eye", "holding"],
  round_trip: ["round trip", "idle"],
  uncertainty: ["clock uncertainty", "fault"],
};
const STAGES = { command: "command", motion: "robot", encoder: "encoder", exposed: "picture taken", shown: "painted" };
const STAGE_TONES = ["accent", "commanded", "encoder", "idle", "engaged"];

export class LatencyRoom {
  #canvas = document.getElementById("latency");
  #context = this.#canvas.getContext("2d");
  #trace = document.getElementById("trace");
  #bar = document.getElementById("trace-bar");
  #cells = new Map();
  #points = new Map(Object.keys(INTERVALS).map((name) => [name, []]));
  #highest = [];

  constructor() {
    const body = document.getElementById("latency-figures");
    for (const [name, [label, tone]] of Object.entries(INTERVALS)) body.append(this.#row(name, label, tone));
  }

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

  show({ now_ms: nowMs, latency, trace }) {
    for (const [name, figures] of Object.entries(latency)) this.#note(name, figures, nowMs);
    this.#highest = Object.values(latency).map((figures) => figures.p95 ?? 0); // rarer values are clipped
    this.#draw(nowMs);
    if (trace !== null) this.#follow(trace);
  }

  #note(name, figures, nowMs) {
    this.#cells.get(name).forEach((cell, k) => {
      const value = [figures.newest, figures.p50, figures.p95][k];
      put(cell, value === null ? "–" : value.toFixed(value < 10 ? 1 : 0));
    });
    const points = this.#points.get(name);
    points.push([nowMs, figures.newest]);
    while (points[0][0] < nowMs - MINUTE_MS) points.shift();
  }

  #follow(trace) {
    put(this.#trace, traceWords(trace));
    const ends = Object.keys(STAGES).map((name) => trace[`${name}_ms`]);
    if (this.#bar.children.length === 0) this.#bar.append(...STAGE_TONES.map(barSegment));
    ends.forEach((end, k) => this.#bar.children[k].style.setProperty("flex-grow", Math.max(0, end - (ends[k - 1] ?? 0))));
  }

  #draw(nowMs) {
    const { width, height } = sized(this.#canvas, this.#context);
    if (width === 0) return; // folded away
    const tone = tones("edge", "faint", ...Object.values(INTERVALS).map(([, name]) => name));
    const most = niceCeiling(Math.max(10, ...this.#highest));
    this.#context.clearRect(0, 0, width, height);
    this.#scale(width, height, most, tone);
    for (const [name, [, colour]] of Object.entries(INTERVALS)) {
      this.#line(this.#points.get(name), ([t, value]) => [
        width * (1 - (nowMs - t) / MINUTE_MS), height - 2 - Math.min(1, value / most) * (height - letter()),
      ], tone[colour]);
    }
  }

  #scale(width, height, most, tone) {
    this.#context.fillStyle = tone.faint;
    this.#context.strokeStyle = tone.edge;
    this.#context.lineWidth = 1;
    this.#context.font = `${0.86 * letter()}px sans-serif`;
    const top = Math.round(letter());
    this.#context.fillText(`${most} ms`, 2, top - 3);
    this.#context.strokeRect(0.5, top - 0.5, width - 1, height - top);
  }

  #line(points, toCanvas, tone) {
    this.#context.strokeStyle = tone;
    this.#context.lineWidth = 1.5;
    this.#context.beginPath();
    let broken = true;
    for (const point of points) {
      if (point[1] !== null) this.#context[broken ? "moveTo" : "lineTo"](...toCanvas(point));
      broken = point[1] === null;
    }
    this.#context.stroke();
  }
}

function niceCeiling(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= value);
}

function barSegment(tone) {
  const segment = document.createElement("span");
  segment.style.setProperty("--tone", `var(--${tone})`);
  return segment;
}

/** One sample's path in words, each stage in ms after the hand's exposure. */
function traceWords({ seq, ...stages }) {
  const words = Object.entries(STAGES).map(([name, word]) => `${word} ${stages[`${name}_ms`].toFixed(0)}`);
  return `sample ${seq}, ms after exposure: ${words.join(", ")}`;
}

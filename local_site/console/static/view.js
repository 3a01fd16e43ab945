// One view: its canvas, painted with the newest picture, and the mark of how current it is.
import { ageWords, judge } from "./freshness.js";
import { Ghost } from "./ghost.js";
import { parsePicture } from "./picture.js";
import { mark as setMark, put } from "./words.js";

const SECOND_MS = 1000;
const USELESS_MS = 1000; // an older picture is darkened, a younger one only marked with its age

export class View {
  why = "";
  #clock;
  #canvas = document.createElement("canvas");
  #context = this.#canvas.getContext("2d", { alpha: false, desynchronized: true });
  #fresh = document.createElement("span");
  #mark = document.createElement("div");
  #title = document.createElement("b");
  #words = document.createElement("span");
  #overlay = document.createElement("canvas");
  #ghost = null;
  #isFresh = false;
  #header = null;
  #newest = null;
  #times = [];

  constructor(clock, name, key) {
    this.#clock = clock;
    this.element = document.createElement("button");
    this.element.type = "button";
    this.element.className = "view";
    this.element.dataset.name = name;
    const label = document.createElement("span");
    label.className = "name";
    label.textContent = `${key ?? ""} ${name.replaceAll("_", " ")}`.trim();
    this.#fresh.className = "fresh";
    this.#mark.className = "mark";
    this.#mark.append(this.#title, this.#words);
    this.element.append(this.#canvas, this.#overlay, this.#mark, label, this.#fresh);
    this.refresh();
  }

  get picture() {
    return this.#canvas;
  }

  get overlay() {
    return this.#overlay;
  }

  /** The ghost is drawn over a calibrated camera's picture; its full picture has this size. */
  describe(camera) {
    this.#ghost = camera.calibration === null ? null : new Ghost(this.#overlay, camera);
  }

  /** Draw the commanded arm over a picture that is young enough to be compared with it, or nothing. */
  haunt(cell, robot) {
    if (this.#ghost === null) return;
    if (robot !== null && this.#isFresh) this.#ghost.draw(cell, robot);
    else this.#ghost.clear();
  }

  /** Take a message of this view; resolves when it is painted or skipped. */
  async receive(bytes) {
    const { header, jpeg } = parsePicture(bytes);
    this.#header = header;
    if (jpeg.length === 0) return;
    const bitmap = await createImageBitmap(new Blob([jpeg], { type: "image/jpeg" }));
    if (this.#newest === null || header.seq > this.#newest.seq || header.capture_ms > this.#newest.captureMs) {
      this.#paint(bitmap, header);
    }
    bitmap.close();
  }

  #paint(bitmap, header) {
    if (this.#canvas.width !== bitmap.width || this.#canvas.height !== bitmap.height) {
      this.#canvas.width = bitmap.width;
      this.#canvas.height = bitmap.height;
    }
    this.#context.drawImage(bitmap, 0, 0);
    const nowMs = this.#clock.now();
    const ageMs = nowMs === null || header.capture_ms === null ? null : nowMs - header.capture_ms;
    this.#newest = { seq: header.seq, captureMs: header.capture_ms, unsureMs: header.unsure_ms ?? 0, ageMs };
    this.#times.push(performance.now());
  }

  /** Mark how current the picture is now. */
  refresh() {
    const { mark, title, words: why, ageMs, isOld } = judge(this.#newest, this.#header, this.#clock.now());
    setMark(this.element, "data-mark", mark);
    setMark(this.element, "data-useless", ageMs === null || ageMs > USELESS_MS);
    this.#isFresh = !isOld && (mark === "live" || mark === "slow");
    put(this.#title, title);
    put(this.#words, why || this.why);
    put(this.#fresh, ageMs === null ? title : `${mark} ${ageWords(ageMs)} ${this.#fps()} fps`);
  }

  /** What was painted last, for the console; null before the first, or while its age is not known. */
  painted() {
    const newest = this.#newest;
    if (newest === null || newest.ageMs === null) return null;
    return { seq: newest.seq, age_ms: Math.max(0, newest.ageMs), fps: this.#fps() };
  }

  #fps() {
    const since = performance.now() - SECOND_MS;
    while (this.#times.length > 0 && this.#times[0] < since) this.#times.shift();
    return this.#times.length;
  }
}

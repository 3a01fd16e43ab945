// One view: its canvas, painted with the newest picture, and the mark of how current it is.
/** @import { Assist, AssistTarget, Camera, Cell, Painted, PictureHeader, Robot, TimedPose } from "../model/messages.d.ts" */
/** @import { H264Decoder } from "./h264_decoder.js" */
/** @import { ViewMessage } from "./picture.js" */
/** @import { Picture } from "./picture_canvas.js" */
/** @import { ServerClock } from "./server_clock.js" */
/** @import { Standing } from "./stale_words.js" */
/** @import { Marked } from "./tool_marks.js" */
/** @import { ToolPath } from "./tool_path.js" */
import { ageWords, judge } from "./freshness.js";
import { decodedJpeg } from "./jpeg.js";
import { PictureCanvas, sizeOf } from "./picture_canvas.js";
import { PictureVideo } from "./picture_video.js";
import { ViewLabels } from "./view_labels.js";
import { ViewOverlays } from "./view_overlays.js";
import { mark as setMark, put } from "./words.js";

/** @typedef {Assist & { target: AssistTarget }} Offer */
/** @typedef {{ seq: number, captureMs: number | null, unsureMs: number, ageMs: number | null, suspendedMs: number }} Newest */

const SECOND_MS = 1000;
const NO_H264 = "this browser cannot decode H.264, which the operator's link needs; open the page in another";
const SHOWING = ["live", "slow"]; // what a camera's picture shows the cell as
const CALM_MS = 600; // without a late picture, until none is marked
const SAME_SHAPE = 0.02; // a picture that is sent smaller has whole pixels only
const USELESS_MS = 1000; // an older picture is darkened, a younger one only marked with its age

export class View {
  why = "";
  onShape = () => {};
  aspect = 4 / 3;
  /** @type {number | null} */
  #calibrated = null; // the shape of the pictures that the projection is for
  #clock;
  #h264;
  #isOfOperator;
  #isMissed = false;
  /** @type {PictureVideo | PictureCanvas} */
  #surface = PictureVideo.isSupported ? new PictureVideo() : new PictureCanvas();
  #labels = new ViewLabels();
  #mark = document.createElement("div");
  #title = document.createElement("b");
  #words = document.createElement("span");
  #overlays = new ViewOverlays();
  #isFresh = false;
  #lateMs = -Infinity;
  /** @type {PictureHeader | null} */
  #header = null;
  /** @type {Newest | null} */
  #newest = null;
  /** @type {number[]} */
  #times = [];

  /** `key` enlarges a view of the cell; one of the operator has none.
   * @param {ServerClock} clock @param {H264Decoder} h264 @param {string} name @param {number | null} key */
  constructor(clock, h264, name, key) {
    this.#clock = clock;
    this.#isOfOperator = key === null;
    this.#h264 = h264;
    this.element = document.createElement("button");
    this.element.type = "button";
    this.element.className = "view";
    this.element.dataset.name = this.name = name;
    this.#labels.call(key, name);
    this.#mark.className = "mark";
    this.#mark.append(this.#title, this.#words);
    this.#surface.element.className = "picture";
    this.element.append(this.#surface.element, ...this.#overlays.canvases, this.#mark, ...this.#labels.elements);
    this.refresh(true);
  }

  /** The pictures have this shape now: whoever lays them out is told when it is another one.
   * @type {(width: number, height: number) => void} */
  #shape(width, height) {
    const aspect = width / height;
    if (Math.abs(aspect - this.aspect) < SAME_SHAPE * aspect) return;
    this.aspect = aspect;
    this.onShape();
  }

  /** Whether anything was heard of it. */
  get isKnown() {
    return this.#header !== null;
  }

  get picture() {
    return this.#surface.element;
  }

  get overlay() {
    return this.#overlays.canvases[0];
  }

  /** The ghost and the tool are drawn over a calibrated camera's picture; its full picture has this size.
   * @type {(camera: Camera, key: number) => void} */
  describe(camera, key) {
    this.#labels.call(key, this.name);
    if (this.#newest === null) this.#shape(camera.width, camera.height);
    this.#calibrated = camera.width / camera.height;
    this.#overlays.describe(camera);
  }

  /** Whether the projection can be for such pictures. */
  get #fits() {
    return this.#calibrated !== null && Math.abs(this.#calibrated - this.aspect) < SAME_SHAPE * this.aspect;
  }

  /** Draw the tool over a picture that is not useless, late as it may be; `path` is where the tool was measured.
   * @type {(tools: Marked | null, path: ToolPath) => void} */
  markTools(tools, path) {
    const isSeen = tools !== null && this.isUseful && this.#fits;
    this.#overlays.markTools(isSeen ? tools : null, isSeen ? this.#toolThen(path) : null);
  }

  /** Draw what the assist offers over a picture that is young enough to be compared with it, or nothing.
   * @type {(assist: Offer | null, path: ToolPath) => void} */
  offer(assist, path) {
    const isSeen = assist !== null && this.#isFresh && this.#fits;
    this.#overlays.offer(isSeen ? assist : null, isSeen ? this.#toolThen(path) : null);
  }

  /** Where the tool was measured when the newest picture was taken; null where that is not known.
   * @type {(path: ToolPath) => TimedPose | null} */
  #toolThen(path) {
    const captureMs = this.#newest?.captureMs ?? null;
    return captureMs === null ? null : path.at(captureMs);
  }

  /** Say what is wrong with all pictures, on this one; empty words say nothing.
   * @type {(words: string) => void} */
  complain(words) {
    this.#labels.complain(words);
  }

  /** Draw the commanded arm over a picture that is young enough to be compared with it, and say so, or nothing.
   * @type {(cell: Cell, robot: Robot | null) => void} */
  showGhost(cell, robot) {
    this.#labels.explain(this.#overlays.showGhost(cell, this.#isFresh && this.#fits ? robot : null));
  }

  /** Take a message of this view; resolves when it is painted or skipped, to false where a key frame is needed.
   * @type {(message: ViewMessage) => Promise<boolean>} */
  async receive({ header, bytes, offset, isPicture }) {
    this.#header = header;
    if (!isPicture) {
      if (header.status === "missing" && this.#isOfOperator) this.#forget();
      return true;
    }
    const picture = await this.#decoded(header, bytes, offset);
    if (picture === null) return this.#isMissed;
    if (this.#newest === null || header.seq > this.#newest.seq || (header.capture_ms ?? 0) > (this.#newest.captureMs ?? 0)) {
      this.#paint(picture, header);
    } else {
      picture.close();
    }
    return true;
  }

  /** The decoded picture: a VideoFrame or an ImageBitmap; null where it cannot be decoded.
   * @type {(header: PictureHeader, bytes: ArrayBuffer, offset: number) => Promise<Picture | null>} */
  #decoded(header, bytes, offset) {
    this.#isMissed = header.codec === "h264" && !this.#h264.supported;
    if (header.codec === "jpeg") return decodedJpeg(bytes, offset);
    return this.#h264.decode(header.view, header.key, bytes, offset);
  }

  #paintOnCanvas() {
    const stuck = this.#surface.element;
    this.#surface = new PictureCanvas();
    this.#surface.element.className = stuck.className;
    stuck.replaceWith(this.#surface.element);
  }

  /** Show no picture: an old one of the operator would be taken for one who is seen now. */
  #forget() {
    this.#newest = null;
    this.#times = [];
    this.#surface.clear();
  }

  /** @type {(picture: Picture, header: PictureHeader) => void} */
  #paint(picture, header) {
    const { width, height } = sizeOf(picture);
    this.#surface.paint(picture);
    this.#shape(width, height);
    const nowMs = this.#clock.now();
    const ageMs = nowMs === null || header.capture_ms === null ? null : nowMs - header.capture_ms;
    this.#newest = { seq: header.seq, captureMs: header.capture_ms, unsureMs: header.unsure_ms ?? 0, ageMs, suspendedMs: this.#clock.suspendedMs };
    const paintedMs = performance.now();
    this.#times.push(paintedMs);
    if (judge(this.#newest, header, nowMs, false).isLate) this.#lateMs = paintedMs; // one that a newer one replaces before the next refresh counts, too
  }

  /** The console's time, and what this host was suspended for since the newest picture; null where it is not known. */
  #now() {
    const nowMs = this.#clock.now();
    const sinceMs = this.#clock.suspendedMs - (this.#newest?.suspendedMs ?? 0);
    return nowMs === null ? null : nowMs + sinceMs;
  }

  /** Mark how current the picture is now; the figures of it only when they can be read.
   * @type {(isRead: boolean) => void} */
  refresh(isRead) {
    if (this.#surface.isStuck) this.#paintOnCanvas();
    const nowMs = performance.now();
    const wasLate = nowMs - this.#lateMs < CALM_MS;
    const { mark, title: judged, words: why, ageMs, isOld, isLate } = judge(this.#surface.isShowing ? this.#newest : null, this.#header, this.#now(), wasLate);
    if (isLate) this.#lateMs = nowMs;
    const title = mark === "live" && this.#clock.isReplayed ? "recorded" : judged;
    if (isRead || mark !== this.element.dataset.mark) {
      put(this.#title, title);
      const word = mark === "live" || (isOld && !isLate) ? title : mark;
      const isKnown = ageMs !== null;
      this.#labels.tell(isKnown ? `${word} ${ageWords(ageMs)}` : title, isKnown && !this.#clock.isStanding ? ` ${this.#fps()} fps` : "");
    }
    setMark(this.element, "data-mark", mark);
    setMark(this.element, "data-useless", ageMs === null || ageMs > USELESS_MS);
    this.#isFresh = !isOld && (mark === "live" || mark === "slow");
    put(this.#words, this.#isMissed ? NO_H264 : why || this.why);
  }

  /** Whether it shows the cell, be it a little late. */
  get isUseful() {
    return this.element.dataset.useless === "false" && this.#header !== null && SHOWING.includes(this.#header.status);
  }

  /** What the next step has to say of it: its mark, whether it shows the cell, and its picture's age in ms, null where unknown.
   * @returns {Standing} */
  get standing() {
    const [captureMs, nowMs] = [this.#newest?.captureMs ?? null, this.#now()];
    const ageMs = captureMs === null || nowMs === null ? null : nowMs - captureMs;
    return { name: this.name.replaceAll("_", " "), mark: this.element.dataset.mark ?? "none", isUseful: this.isUseful, ageMs };
  }

  /** What was painted last, for the console; null before the first, or while its age is not known.
   * @type {() => Painted | null} */
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

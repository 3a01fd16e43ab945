// All views: those of the cell, with what is drawn over them, and those of the operator.
/** @import { Cell, Hand, PageMessage, Painted, Robot, ToolPoses } from "../model/messages.d.ts" */
/** @import { ServerClock } from "./server_clock.js" */
/** @import { Offer } from "./view.js" */
import { element } from "./elements.js";
import { H264Decoder } from "./h264_decoder.js";
import { NoViews } from "./no_views.js";
import { parsePicture } from "./picture.js";
import { PictureRoom } from "./picture_room.js";
import { RememberedToggle } from "./remembered_toggle.js";
import { staleWords } from "./stale_words.js";
import { ToolPath } from "./tool_path.js";
import { View } from "./view.js";

const CAMERA = "camera/";
const PREVIEWS = ["left", "right"];

export class Views {
  #clock;
  #send;
  #h264 = new H264Decoder();
  #room = new PictureRoom();
  #noViews = new NoViews();
  /** @type {Map<string, View>} */
  #views = new Map();
  /** @type {View[]} */
  #previews = [];
  /** @type {Cell | null} */
  #cell = null;
  /** @type {Robot | null} */
  #robot = null;
  /** @type {Offer | null} */
  #offered = null;
  /** @type {ToolPoses} */
  #tools = { measured: null, sent: null, wanted: null };
  /** @type {string | null} */
  #limit = null;
  #isCalibrated = false;
  #path = new ToolPath();
  /** @type {Set<string>} */
  #received = new Set();
  #ghost = new RememberedToggle("ghost", "g", true, () => this.#draw());
  #marks = new RememberedToggle("marks", "t", true, () => this.markTools(this.#tools));

  /** @param {ServerClock} clock @param {(message: PageMessage) => unknown} send */
  constructor(clock, send) {
    this.#clock = clock;
    this.#send = send;
    this.#previews = PREVIEWS.map((name) => this.#add(`preview/${name}`, `operator ${name}`, null));
    element("previews").append(...this.#previews.map((view) => view.element));
  }

  /** Show a view for each camera of the cell, in their order, and none of any other.
   * @type {(cell: Cell) => void} */
  describe(cell) {
    this.#cell = cell;
    const names = cell.cameras.map(({ name }) => CAMERA + name);
    for (const name of this.#views.keys()) if (name.startsWith(CAMERA) && !names.includes(name)) this.#views.delete(name);
    const shown = cell.cameras.map((camera, k) => {
      const view = this.#views.get(CAMERA + camera.name) ?? this.#add(CAMERA + camera.name, camera.name, k + 1);
      view.describe(camera, k + 1);
      return view;
    });
    this.#room.show(shown);
    this.#isCalibrated = cell.cameras.some((camera) => camera.calibration !== null);
    element("overlays").hidden = !this.#isCalibrated;
  }

  /** Lay the views out anew: the letters have changed. */
  arrange() {
    this.#room.arrange();
  }

  /** Draw the commanded arm over the calibrated cameras' pictures.
   * @type {(robot: Robot | null) => void} */
  showGhost(robot) {
    this.#robot = this.#cell !== null && robot !== null && !robot.silent ? robot : null;
    this.#draw();
  }

  /** Draw the marker and the tool's pose of what the assist offers or does over the cameras that see the marker.
   * @type {(robot: Robot | null) => void} */
  offer(robot) {
    const assist = robot === null || robot.silent ? null : robot.assist;
    this.#offered = assist?.target ? { ...assist, target: assist.target } : null;
    this.#draw();
  }

  #draw() {
    if (this.#cell === null || !this.#isCalibrated || document.hidden) return; // nothing is drawn over the pictures
    for (const [name, view] of this.#views) {
      view.showGhost(this.#cell, this.#ghost.isOn ? this.#robot : null);
      const sees = this.#offered?.target.views.some((camera) => name === CAMERA + camera);
      view.offer(sees ? this.#offered : null, this.#path);
    }
  }

  /** The name of the limit that keeps the arm from following, null while none does.
   * @type {(limit: string | null) => void} */
  showLimit(limit) {
    this.#limit = limit;
  }

  /** Draw the tool as measured and where it has been sent, whenever pictures come.
   * @type {(tools: ToolPoses) => void} */
  markTools(tools) {
    this.#tools = tools;
    if (tools.measured !== null) this.#path.add(tools.measured);
    if (!this.#isCalibrated || document.hidden) return;
    for (const view of this.#views.values()) view.markTools(this.#marks.isOn ? { ...this.#tools, limit: this.#limit } : null, this.#path);
  }

  /** Take a picture, and report to the console when the next may come.
   * @type {(bytes: ArrayBuffer) => Promise<void>} */
  async receive(bytes) {
    const message = parsePicture(bytes);
    const name = message.header.view;
    if (message.isPicture) this.#received.add(name);
    try {
      if ((await this.#views.get(name)?.receive(message)) === false) this.#send({ type: "lost", view: name });
    } finally {
      this.#send({ type: "taken", view: name });
    }
  }

  /** The operator's left view, or the only one. */
  get ofOperator() {
    return this.#previews[0];
  }

  /** Whether one camera sees the operator. */
  get isOneCamera() {
    const [left, right] = PREVIEWS.map((name) => this.#received.has(`preview/${name}`));
    return left && !right;
  }

  /** Forget where the tool was: the time has jumped. */
  forget() {
    this.#path = new ToolPath();
  }

  /** @type {(isRead: boolean) => void} */
  refresh(isRead) {
    for (const view of this.#views.values()) view.refresh(isRead);
    const [left, right] = this.#previews;
    right.element.hidden = left.isKnown && !right.isKnown; // one camera has all the room
  }

  /** Which views of the cell do not show it as it is now, in words, empty where all do or there is none. */
  get stale() {
    return staleWords([...this.#views].filter(([name]) => name.startsWith(CAMERA)).map(([, view]) => view.standing));
  }

  /** Whether this browser decodes H.264; false until it is known. */
  get decodesH264() {
    return this.#h264.supported;
  }

  /** What is shown of the cell, for the console.
   * @type {() => Record<string, Painted>} */
  painted() {
    /** @type {Record<string, Painted>} */
    const shown = {};
    for (const [name, view] of this.#views) {
      const painted = view.painted();
      if (painted !== null && name.startsWith(CAMERA)) shown[name] = painted;
    }
    return shown;
  }

  /** Say what is wrong with the pictures of the cell, on the one that is looked at most; empty where nothing is.
   * @type {(trouble: string) => void} */
  complain(trouble) {
    for (const [name, view] of this.#views) if (name.startsWith(CAMERA)) view.complain(view === this.#room.main ? trouble : "");
  }

  /** Say why there are no views of the cell, or none of the operator; `hand` is null in a replay.
   * @type {(hand: Hand | null, isReplay: boolean) => void} */
  sayWhatIsMissing(hand, isReplay) {
    const silent = hand === null || hand.silent;
    this.#noViews.show(this.#cell === null ? null : this.#cell.cameras.length, !silent, isReplay);
    const why = silent ? "no preview: the local site is silent" : "no preview: the local site sends none";
    for (const view of this.#previews) view.why = why;
  }

  /** @type {(key: string, label: string, number: number | null) => View} */
  #add(key, label, number) {
    const view = new View(this.#clock, this.#h264, label, number);
    this.#views.set(key, view);
    return view;
  }
}

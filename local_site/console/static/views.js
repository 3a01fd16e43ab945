// All views: four of the cell, each enlarged by a click or its number, and those of the operator below.
import { H264Decoder } from "./h264_decoder.js";
import { canPress, isPlain, pressByKey } from "./keys.js";
import { parsePicture } from "./picture.js";
import { ToolPath } from "./tool_path.js";
import { View } from "./view.js";

const PREVIEWS = ["left", "right"];
const SMALL_IN_A_ROW = 5;

export class Views {
  #clock;
  #send;
  #h264 = new H264Decoder();
  #cameras = document.getElementById("cameras");
  #previews = document.getElementById("previews");
  #views = new Map();
  #cell = null;
  #robot = null;
  #haunted = true;
  #offered = null;
  #tools = { measured: null, sent: null, wanted: null };
  #limit = null;
  #marked = true;
  #isCalibrated = false;
  #path = new ToolPath();
  #marksButton = document.getElementById("marks");
  #received = new Set();
  #ghostButton = document.getElementById("ghost");

  constructor(clock, send) {
    this.#clock = clock;
    this.#send = send;
    for (const name of PREVIEWS) this.#add(this.#previews, `preview/${name}`, `operator ${name}`, null);
    this.#ghostButton.addEventListener("click", () => this.#toggleGhost());
    this.#marksButton.addEventListener("click", () => this.#toggleMarks());
    pressByKey({ g: this.#ghostButton, t: this.#marksButton });
    addEventListener("keydown", (event) => this.#key(event));
  }

  /** Make a view for each camera of the cell that has none yet. */
  describe(cell) {
    this.#cell = cell;
    for (const camera of cell.cameras) {
      const view = `camera/${camera.name}`;
      if (!this.#views.has(view)) this.#add(this.#cameras, view, camera.name, this.#cameras.children.length + 1);
      this.#views.get(view).describe(camera);
    }
    this.#cameras.dataset.count = cell.cameras.length;
    document.documentElement.style.setProperty("--aspect", aspectOf(cell.cameras));
    this.#isCalibrated = cell.cameras.some((camera) => camera.calibration !== null);
    this.#marksButton.hidden = this.#ghostButton.hidden = !this.#isCalibrated;
  }

  /** Draw the commanded arm over the calibrated cameras' pictures. */
  haunt(robot) {
    this.#robot = this.#haunted && this.#cell !== null && robot !== null && !robot.silent ? robot : null;
    this.#draw();
  }

  /** Draw the marker and the tool's pose of what the assist offers or does over the cameras that see the marker. */
  offer(robot) {
    this.#offered = robot === null || robot.silent || !robot.assist?.target ? null : robot.assist;
    this.#draw();
  }

  #draw() {
    if (!this.#isCalibrated || document.hidden) return; // nothing is drawn over the pictures
    for (const [name, view] of this.#views) {
      view.haunt(this.#cell, this.#robot);
      const sees = this.#offered?.target.views.some((camera) => name === `camera/${camera}`);
      view.offer(sees ? this.#offered : null, this.#path);
    }
  }

  /** The name of the limit that keeps the arm from following, null while none does. */
  hinder(limit) {
    this.#limit = limit;
  }

  /** Draw the tool as measured and where it has been sent, whenever pictures come. */
  markTools(tools) {
    this.#tools = tools;
    if (tools.measured !== null) this.#path.add(tools.measured);
    if (!this.#isCalibrated || document.hidden) return;
    for (const view of this.#views.values()) view.markTools(this.#marked ? { ...this.#tools, limit: this.#limit } : null, this.#path);
  }

  /** Take a picture, and report to the console when the next may come. */
  async receive(bytes) {
    const { header: { view: name }, isPicture } = parsePicture(bytes);
    if (isPicture) this.#received.add(name);
    try {
      if ((await this.#views.get(name)?.receive(bytes)) === false) this.#send({ type: "lost", view: name });
    } finally {
      this.#send({ type: "taken", view: name });
    }
  }

  /** The operator's left view, or the only one. */
  get ofOperator() {
    return this.#views.get(`preview/${PREVIEWS[0]}`);
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

  refresh() {
    for (const view of this.#views.values()) view.refresh();
  }

  /** Whether no view shows the cell. */
  get isBlind() {
    return [...this.#views].every(([name, view]) => !name.startsWith("camera/") || !view.isUseful);
  }

  /** Whether this browser decodes H.264; false until it is known. */
  get decodesH264() {
    return this.#h264.supported;
  }

  /** What is shown of the cell, for the console. */
  painted() {
    const shown = [...this.#views].map(([name, view]) => [name, view.painted()]);
    return Object.fromEntries(shown.filter(([name, painted]) => painted !== null && name.startsWith("camera/")));
  }

  showWhyNoPreview(hand) {
    const silent = hand === null || hand.silent;
    const why = silent ? "no preview: the local site is silent" : "no preview: the local site sends none";
    for (const name of PREVIEWS) this.#views.get(`preview/${name}`).why = why;
  }

  #add(room, key, label, number) {
    const view = new View(this.#clock, this.#h264, label, number);
    this.#views.set(key, view);
    room.append(view.element);
    if (number !== null) view.element.addEventListener("click", () => this.#enlarge(view.element));
  }

  #key(event) {
    const chosen = this.#cameras.children[Number.parseInt(event.key, 10) - 1];
    if (chosen !== undefined && isPlain(event) && canPress(chosen)) this.#enlarge(chosen);
  }

  #toggleGhost() {
    this.#haunted = !this.#haunted;
    this.#ghostButton.setAttribute("aria-pressed", this.#haunted);
  }

  #toggleMarks() {
    this.#marked = !this.#marked;
    this.#marksButton.setAttribute("aria-pressed", this.#marked);
    this.markTools(this.#tools);
  }

  #enlarge(chosen) {
    const enlarging = !chosen.classList.contains("enlarged");
    for (const view of this.#cameras.children) view.classList.toggle("enlarged", enlarging && view === chosen);
    [...this.#cameras.children].filter((view) => view !== chosen).forEach(placeSmall);
    this.#cameras.classList.toggle("enlarging", enlarging);
  }
}

/** Where a view lies while another one is enlarged: in rows from the upper right. */
function placeSmall(view, k) {
  view.style.setProperty("--column", k % SMALL_IN_A_ROW);
  view.style.setProperty("--row", Math.floor(k / SMALL_IN_A_ROW));
}

/** The shape of all views together, two in a row: that of the pictures, which then leave no bars. */
function aspectOf(cameras) {
  const { width, height } = cameras[0] ?? { width: 4, height: 3 };
  const rows = cameras.length === 1 ? 1 : Math.ceil(cameras.length / 2);
  const columns = cameras.length === 1 ? 1 : 2;
  return `${(columns * width) / (rows * height)}`;
}

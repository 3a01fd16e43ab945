// The mark that something is recorded, for everybody to see, and what the operator asks of the recorder.
/** @import { Recording, Request, Robot } from "../model/messages.d.ts" */
/** @import { Alert } from "./alert.js" */
/** @import { Connection } from "./connection.js" */
import { element, tagged } from "./elements.js";
import { pressByKey } from "./keys.js";
import { clockWords, mark, put } from "./words.js";

const KEYS = { p: "episode", s: "success", f: "failure" };

export class RecordingRow {
  #connection;
  #alert;
  /** @type {Recording[]} */
  #recorders = [];
  #operates = false;
  #mark = element("recording");
  #row = element("recording-row");
  #buttons = Object.fromEntries(["record", ...Object.values(KEYS)].map((name) => [name, tagged("button", name)]));

  /** @param {Connection} connection @param {Alert} alert */
  constructor(connection, alert) {
    this.#connection = connection;
    this.#alert = alert;
    for (const [name, button] of Object.entries(this.#buttons)) button.addEventListener("click", () => this.#act(name));
    pressByKey(Object.fromEntries(Object.entries(KEYS).map(([key, name]) => [key, this.#buttons[name]])));
  }

  /** Show what the recorders of the cell and of the operator's own side do; without one nothing is shown.
   * @type {(robot: Robot | null, own: Recording | null, operates: boolean) => void} */
  show(robot, own, operates) {
    const ofCell = robot === null || robot.silent ? null : robot.recording;
    this.#recorders = [ofCell, own].filter((one) => one !== null);
    this.#operates = operates;
    const alarm = this.#recorders.map((one) => one.alarm).find((words) => words !== "");
    this.#row.hidden = this.#recorders.length === 0;
    this.#mark.hidden = this.#writing.length === 0;
    if (alarm === undefined) this.#alert.clear("recording");
    else this.#alert.show("recording", "bad", alarm);
    put(this.#mark, markWords(this.#writing));
    put(element("episode-words"), this.#bounded === null ? "nothing is recorded" : episodeWords(this.#bounded));
    put(this.#buttons.record, this.#isEndable ? "End recording" : "Record");
    this.#buttons.record.hidden = !this.#recorders.some((one) => one.on_request);
    this.#buttons.record.disabled = !operates;
    mark(this.#buttons.episode, "aria-pressed", this.#bounded?.episode_open ?? false);
    for (const name of Object.values(KEYS)) this.#buttons[name].disabled = !this.#can(name);
  }

  disconnected() {
    this.#operates = false;
    this.#mark.hidden = true;
    for (const button of Object.values(this.#buttons)) button.disabled = true;
  }

  get #writing() {
    return this.#recorders.filter((one) => one.writing);
  }

  /** Whose episodes the keys bound: those of the cell's recording, or else of the operator's own. */
  get #bounded() {
    return this.#writing[0] ?? null;
  }

  get #isEndable() {
    return this.#writing.some((one) => one.on_request);
  }

  /** @type {(name: string) => boolean} */
  #can(name) {
    if (!this.#operates || this.#bounded === null) return false;
    return name === "episode" || this.#bounded.episode > 0;
  }

  /** @type {(name: string) => void} */
  #act(name) {
    /** @type {Record<string, Request>} */
    const requests = {
      record: { type: "ask_record", action: this.#isEndable ? "stop" : "start" },
      episode: { type: "ask_record", action: this.#bounded?.episode_open ? "end" : "begin" },
      success: { type: "ask_record", action: "label", outcome: "success" },
      failure: { type: "ask_record", action: "label", outcome: "failure" },
    };
    this.#connection.ask(requests[name]);
  }
}

/** What is recorded, for how long and how much: of several recorders the longest time, and what all have written.
 * @type {(writing: Recording[]) => string} */
function markWords(writing) {
  if (writing.length === 0) return "";
  const words = [writing.some((one) => one.operator_pictures) ? "REC, with the operator's pictures" : "REC"];
  words[0] += ` ${clockWords(Math.max(...writing.map((one) => one.seconds)))}`;
  words.push(sizeWords(writing.reduce((sum, one) => sum + one.size_bytes, 0)));
  const [{ episode, episode_open: isOpen, episode_seconds: seconds }] = writing;
  if (isOpen) words.push(`episode ${episode} ${clockWords(seconds)}`);
  const lost = writing.reduce((sum, one) => sum + one.lost, 0);
  if (lost > 0) words.push(`${lost} lost`);
  return words.join(" · ");
}

/** @type {(bytes: number) => string} */
function sizeWords(bytes) {
  return bytes < 1e9 ? `${Math.round(bytes / 1e6)} MB` : `${(bytes / 1e9).toFixed(1)} GB`;
}

/** @type {(recording: Recording) => string} */
function episodeWords({ episode, episode_open, episode_seconds: seconds, task, outcome }) {
  if (episode === 0) return task === "" ? "no episode yet" : `no episode yet: ${task}`;
  const words = [`episode ${episode}${episode_open ? "" : " has ended"}`, clockWords(seconds)];
  if (task !== "") words.push(task);
  if (outcome !== "unknown") words.push(outcome);
  return words.join(" · ");
}

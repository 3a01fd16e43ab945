// The mark that something is recorded, for everybody to see, and what the operator asks of the recorder.
import { mark, put } from "./words.js";

const KEYS = { p: "episode", s: "success", f: "failure" };
const element = (id) => document.getElementById(id);

export class RecordingRow {
  #connection;
  #alert;
  #recording = null;
  #operates = false;
  #mark = element("recording");
  #row = element("recording-row");
  #buttons = Object.fromEntries(["record", ...Object.values(KEYS)].map((name) => [name, element(name)]));

  constructor(connection, alert) {
    this.#connection = connection;
    this.#alert = alert;
    for (const [name, button] of Object.entries(this.#buttons)) button.addEventListener("click", () => this.#act(name));
    addEventListener("keydown", (event) => this.#key(event));
  }

  /** Show what the recorders of the cell and of the operator's own side do; without one nothing is shown. */
  show(robot, own, operates) {
    const recording = robot === null || robot.silent ? null : robot.recording;
    const both = [recording, own].filter((one) => one !== null);
    const writing = both.filter((one) => one.writing);
    const alarm = both.map((one) => one.alarm).find((words) => words !== "");
    this.#recording = recording;
    this.#operates = operates;
    this.#row.hidden = recording === null;
    this.#mark.hidden = writing.length === 0;
    if (alarm === undefined) this.#alert.clear("recording");
    else this.#alert.show("recording", "bad", alarm);
    put(this.#mark, markWords(writing));
    if (recording === null) return;
    put(element("episode-words"), recording.writing ? episodeWords(recording) : "nothing is recorded");
    put(this.#buttons.record, recording.writing ? "End recording" : "Record");
    this.#buttons.record.hidden = !recording.on_request;
    this.#buttons.record.disabled = !operates;
    mark(this.#buttons.episode, "aria-pressed", recording.episode_open);
    for (const name of Object.values(KEYS)) this.#buttons[name].disabled = !this.#can(name);
  }

  disconnected() {
    this.#operates = false;
    this.#mark.hidden = true;
    for (const button of Object.values(this.#buttons)) button.disabled = true;
  }

  #can(name) {
    const recording = this.#recording;
    if (!this.#operates || recording === null || !recording.writing) return false;
    return name === "episode" || recording.episode > 0;
  }

  #key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.repeat) return;
    const name = KEYS[event.key.toLowerCase()];
    if (name !== undefined && this.#can(name)) this.#act(name);
  }

  #act(name) {
    const { writing, episode_open } = this.#recording;
    const asked = {
      record: { action: writing ? "stop" : "start" },
      episode: { action: episode_open ? "end" : "begin" },
      success: { action: "label", outcome: "success" },
      failure: { action: "label", outcome: "failure" },
    }[name];
    this.#connection.ask({ type: "ask_record", ...asked });
  }
}

function markWords(writing) {
  const words = writing.some((one) => one.operator_pictures) ? ["REC, with the operator's pictures"] : ["REC"];
  const lost = writing.reduce((sum, one) => sum + one.lost, 0);
  if (lost > 0) words.push(`${lost} lost`);
  return words.join(" · ");
}

function episodeWords({ episode, episode_open, task, outcome }) {
  if (episode === 0) return task === "" ? "no episode yet" : `no episode yet: ${task}`;
  const words = [`episode ${episode}${episode_open ? "" : " has ended"}`];
  if (task !== "") words.push(task);
  if (outcome !== "unknown") words.push(outcome);
  return words.join(" · ");
}

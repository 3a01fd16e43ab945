// The state in words, with its reason, and the list of events.
import { ageWords } from "./freshness.js";
import { troubles } from "./link_line.js";
import { mark, put } from "./words.js";

const SILENT_MS = 500;
const LIVE = {
  lost: "the console does not answer: the held key has no effect, and the arm may be moving",
  none: ["no robot", "no state has come from the remote site yet"],
  silent: (age) => `the remote site has been silent for ${age}`,
};
const RECORDED = {
  lost: "the program that replays does not answer",
  none: ["nothing", "no state is recorded up to here"],
  silent: (age) => `no state is recorded for ${age}`,
};

export class StatePanel {
  #state = document.getElementById("state");
  #word = document.getElementById("state-word");
  #reason = document.getElementById("reason");
  #cell = document.getElementById("cell");
  #events = document.getElementById("events");
  #receivedMs = null;
  #connected = false;
  #said = LIVE;

  /** A page that shows a recording has other words for what is missing. */
  hello({ replay }) {
    this.#said = replay === null ? LIVE : RECORDED;
  }

  describe(cell) {
    this.#cell.textContent = `${cell.cell} · ${cell.robot} · ${cell.driver}`;
  }

  disconnected() {
    this.#connected = false;
    this.#set("silent", "no connection", this.#said.lost);
  }

  /** Whether the console has fallen silent with its connection open. */
  get isSilent() {
    return this.#connected && performance.now() - this.#receivedMs > SILENT_MS;
  }

  show({ robot, events }) {
    this.#connected = true;
    this.#receivedMs = performance.now();
    this.#showRobot(robot);
    this.#list(events);
  }

  #showRobot(robot) {
    if (robot === null) this.#set("silent", ...this.#said.none);
    else if (robot.silent && robot.code === "site_ended") this.#set("silent", "ended", robot.reason);
    else if (robot.silent) this.#set("silent", "silent", this.#said.silent(ageWords(robot.heard_ms)));
    else if (robot.readiness.code === "stopped") this.#set("stopped", "stopped", robot.reason);
    else {
      const missing = robot.state === "disengaged" && robot.readiness.reason !== robot.reason ? [robot.readiness.reason] : [];
      this.#set(robot.state, robot.state, [robot.reason, ...missing, ...troubles(robot)].join(" · "));
    }
  }

  #set(state, word, reason) {
    mark(this.#state, "data-state", state);
    put(this.#word, word);
    put(this.#reason, reason);
  }

  #list(events) {
    while (this.#events.children.length > events.length) this.#events.lastChild.remove();
    while (this.#events.children.length < events.length) this.#events.append(emptyEvent());
    events.forEach((event, k) => fill(this.#events.children[k], event));
  }
}

function emptyEvent() {
  const item = document.createElement("li");
  item.append(document.createElement("time"), document.createElement("span"));
  return item;
}

function fill(item, event) {
  put(item.firstChild, event.ago_ms < 1000 ? "now" : `${Math.floor(event.ago_ms / 1000)} s`);
  if (item.dataset.number === String(event.number)) return;
  item.dataset.number = event.number;
  item.dataset.kind = event.kind;
  item.lastChild.textContent = event.text;
}

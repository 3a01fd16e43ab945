// Connects the page's sections: messages from the console go to each, the operator's actions go back.
/** @import { Messages, Situation, ToolPoses } from "../model/messages.d.ts" */
/** @import { Condition } from "./condition.js" */
import { Alert } from "./alert.js";
import { ArmRoom } from "./arm_room.js";
import { AssistKey } from "./assist_key.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { DelayPanel } from "./delay_panel.js";
import { tagged } from "./elements.js";
import { EventList } from "./event_list.js";
import { HoldKey } from "./hold_key.js";
import { JointMarks } from "./joint_marks.js";
import { LatencyRoom } from "./latency_room.js";
import { measureLetters } from "./letters.js";
import { LinkLine, pictureTrouble } from "./link_line.js";
import { RecordingRow } from "./recording_row.js";
import { RememberedToggle } from "./remembered_toggle.js";
import { ReplayBar } from "./replay_bar.js";
import { ServerClock } from "./server_clock.js";
import { StateBar } from "./state_bar.js";
import { Steps } from "./steps.js";
import { StopButton } from "./stop_button.js";
import { Theme } from "./theme.js";
import { Tones } from "./tones.js";
import { Views } from "./views.js";
import { READ_MS, mark } from "./words.js";

const BEAT_MS = 50;
const LOOK_MS = 100;
const OLD_TOOLS_MS = 300;
/** @type {ToolPoses} */
const NO_TOOLS = { measured: null, sent: null, wanted: null };

const clock = new ServerClock();
const connection = new Connection();
const views = new Views(clock, (message) => connection.send(message));
const tones = new Tones();
const bar = new StateBar((name) => tones.play(name));
const steps = new Steps();
const events = new EventList();
const arm = new ArmRoom();
const latency = new LatencyRoom();
const link = new LinkLine();
const hold = new HoldKey(tagged("button", "hold"), "Space", beat);
const assist = new AssistKey(beat);
const clutch = new HoldKey(tagged("button", "clutch"), "KeyC", beat);
const alert = new Alert();
const stop = new StopButton(connection, alert, () => {
  hold.release();
  assist.release();
});
const controls = new Controls(connection, alert);
const recording = new RecordingRow(connection, alert);
const delay = new DelayPanel(clock, (scale) => controls.steer({ scale }));
const replay = new ReplayBar(connection, alert, () => views.forget());
const joints = new JointMarks(connection, views.ofOperator);
new Theme(() => arm.repaint());
new RememberedToggle("type", "l", false, (isLarge) => {
  document.documentElement.dataset.type = isLarge ? "large" : "usual";
  measureLetters();
  views.arrange();
  arm.repaint();
});

/** @type {ToolPoses} */
let tools = NO_TOOLS;
let toolsMs = -Infinity;
let lookedMs = -Infinity;
let readMs = -Infinity;
let armMs = -Infinity;
/** @type {Situation | null} */
let newest = null;
/** @type {number | null} */
let heardMs = null; // the console's time in its newest echo: how old what the page sends is at most

function beat() {
  const clutched = clutch.down ? "down" : clutch.isUnseen ? "unseen" : "up";
  connection.send({ type: "beat", page_ms: performance.now(), heard_ms: heardMs, down: hold.down, assist: assist.asked, clutch: clutched });
}

/** @type {{ [K in keyof Messages]: (message: Messages[K]) => void }} */
const handlers = {
  hello: (message) => {
    bar.hello(message);
    controls.hello(message);
    replay.hello(message);
  },
  replay: (message) => {
    clock.follow(message.now_ms, message.running ? message.speed : 0);
    replay.show(message);
  },
  echo: (message) => {
    clock.add(message.page_ms, message.server_ms, performance.now());
    heardMs = message.server_ms;
  },
  cell: (message) => {
    views.describe(message.cell);
    arm.describe(message.cell);
    bar.describe(message.cell);
    steps.describe(message.cell);
    controls.describe(message.cell);
  },
  situation: (message) => {
    newest = message;
    look();
  },
  tools: (message) => {
    toolsMs = performance.now();
    showTools(message);
  },
  answer: (message) => {
    stop.onReply(message);
    controls.onReply(message);
  },
};

/** @type {<K extends keyof Messages>(kind: K, message: Messages[K]) => void} */
const handle = (kind, message) => handlers[kind](message);

connection.onText = (message) => handle(message.type, message);
connection.onPicture = (bytes) => views.receive(bytes);
connection.onChange = (open) => {
  if (open) return;
  heardMs = null;
  disconnected();
};

/** Show everything but the pictures: all at once, for each change that the browser draws by itself has it draw the page once more.
 * Figures change when they can be read. */
function look() {
  lookedMs = performance.now();
  const isRead = lookedMs - readMs >= READ_MS;
  if (isRead) readMs = lookedMs;
  if (newest !== null) show(newest, isRead);
  views.refresh(isRead);
  if (isRead) arm.tell();
  if (lookedMs - armMs >= LOOK_MS) {
    armMs = lookedMs; // its drawing costs more than all others
    arm.refresh();
  }
  joints.offer(views.isOneCamera);
  if (bar.isSilent) disconnected();
  if (lookedMs - toolsMs > OLD_TOOLS_MS) showTools(NO_TOOLS);
  stop.refresh();
  newest = null;
}

/** @type {(situation: Situation, isRead: boolean) => void} */
function show(situation, isRead) {
  mark(document.body, "data-connected", true);
  const condition = bar.show(situation, isRead);
  arm.show(situation.robot);
  const limit = condition.limit ?? null;
  arm.showLimit(limit);
  views.showLimit(limit);
  views.showGhost(situation.robot);
  views.offer(situation.robot);
  views.sayWhatIsMissing(situation.hand, replay.isShown);
  if (!replay.isShown) operate(situation, condition);
  if (isRead) showFigures(situation);
}

/** What belongs to a live cell alone: its controls, and what its operator is told to do.
 * @type {(situation: Situation, condition: Condition) => void} */
function operate(situation, condition) {
  stop.show(situation);
  controls.show(situation);
  steps.show(condition, situation, { ...controls.facts, down: hold.down, stale: views.stale, tools });
  assist.show(situation.robot, controls.operates);
  recording.show(situation.robot, situation.own_recording, controls.operates);
}

/** @type {(situation: Situation) => void} */
function showFigures(situation) {
  events.show(situation);
  latency.show(situation);
  if (replay.isShown) return;
  views.complain(situation.robot === null || situation.robot.silent ? "" : pictureTrouble(situation.robot, situation.clock));
  delay.show(situation, tools);
  link.show(situation.robot);
}

/** @type {(newest: ToolPoses) => void} */
function showTools(newest) {
  tools = newest;
  views.markTools(tools);
  arm.want(tools.wanted);
}

/** Mark everything besides the pictures, which show their own age, as outdated. */
function disconnected() {
  mark(document.body, "data-connected", false);
  bar.disconnected();
  steps.disconnected();
  controls.disconnected();
  stop.disconnected();
  assist.disconnected();
  recording.disconnected();
  views.offer(null);
  views.complain("");
  delay.disconnected();
}

setInterval(beat, BEAT_MS);
setInterval(() => {
  if (performance.now() - lookedMs >= LOOK_MS) look(); // no situations come
  connection.send({ type: "shown", h264: views.decodesH264, views: views.painted() });
}, LOOK_MS);
connection.open();

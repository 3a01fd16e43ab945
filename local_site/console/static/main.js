// Connects the page's sections: messages from the console go to each, the operator's actions go back.
import { Alert } from "./alert.js";
import { ArmRoom } from "./arm_room.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { HoldKey } from "./hold_key.js";
import { JointMarks } from "./joint_marks.js";
import { LatencyRoom } from "./latency_room.js";
import { ServerClock } from "./server_clock.js";
import { StatePanel } from "./state_panel.js";
import { StopButton } from "./stop_button.js";
import { Views } from "./views.js";
import { mark } from "./words.js";

const BEAT_MS = 50;
const LOOK_MS = 100;

const clock = new ServerClock();
const connection = new Connection();
const views = new Views(clock, (message) => connection.send(message));
const panel = new StatePanel();
const arm = new ArmRoom();
const latency = new LatencyRoom();
const hold = new HoldKey(beat);
const alert = new Alert();
const stop = new StopButton(connection, alert, () => hold.release());
const controls = new Controls(connection, alert);
const joints = new JointMarks(connection, views.ofOperator);

function beat() {
  connection.send({ type: "beat", page_ms: performance.now(), down: hold.down });
}

const handlers = {
  hello: (message) => controls.hello(message),
  echo: (message) => clock.add(message.page_ms, message.server_ms, performance.now()),
  cell: (message) => {
    views.describe(message.cell);
    arm.describe(message.cell);
    panel.describe(message.cell);
    controls.describe(message.cell);
  },
  situation: (message) => {
    mark(document.body, "data-connected", true);
    panel.show(message);
    stop.show(message);
    controls.show(message);
    arm.show(message.robot);
    views.haunt(message.robot);
    latency.show(message);
    views.showWhyNoPreview(message.hand);
  },
  answer: (message) => {
    stop.onReply(message);
    controls.onReply(message);
  },
};

connection.onText = (message) => handlers[message.type](message);
connection.onPicture = (bytes) => views.receive(bytes);
connection.onChange = (open) => {
  if (!open) disconnected();
};

/** Mark everything besides the pictures, which show their own age, as outdated. */
function disconnected() {
  mark(document.body, "data-connected", false);
  panel.disconnected();
  controls.disconnected();
  stop.disconnected();
}

setInterval(beat, BEAT_MS);
setInterval(() => {
  views.refresh();
  joints.offer(views.isOneCamera);
  if (panel.isSilent) disconnected();
  stop.refresh();
  connection.send({ type: "shown", views: views.painted() });
}, LOOK_MS);
connection.open();

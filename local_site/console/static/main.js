// Puts the page's rooms together: what comes from the console goes to each, what the operator does goes back.
import { ArmRoom } from "./arm_room.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { HoldKey } from "./hold_key.js";
import { LatencyRoom } from "./latency_room.js";
import { ServerClock } from "./server_clock.js";
import { StatePanel } from "./state_panel.js";
import { StopButton } from "./stop_button.js";
import { Views } from "./views.js";

const BEAT_MS = 50;
const LOOK_MS = 100;

const clock = new ServerClock();
const connection = new Connection();
const views = new Views(clock, (message) => connection.send(message));
const panel = new StatePanel();
const arm = new ArmRoom();
const latency = new LatencyRoom();
const hold = new HoldKey(beat);
const stop = new StopButton(connection, () => hold.release());
const controls = new Controls(connection);

function beat() {
  connection.send({ type: "beat", page_ms: performance.now(), down: hold.down });
}

const hearers = {
  hello: (told) => controls.hello(told),
  echo: (told) => clock.add(told.page_ms, told.server_ms, performance.now()),
  cell: (told) => {
    views.describe(told.cell);
    arm.describe(told.cell);
    panel.describe(told.cell);
  },
  situation: (told) => {
    panel.show(told);
    stop.show(told);
    controls.show(told);
    arm.show(told.robot);
    views.haunt(told.robot);
    latency.show(told);
    views.sayWhyNoPreview(told.hand);
  },
  answer: (told) => {
    stop.hear(told);
    controls.hear(told);
  },
};

connection.onText = (told) => hearers[told.type](told);
connection.onPicture = (bytes) => views.hear(bytes);
connection.onChange = (open) => {
  if (!open) panel.disconnected();
};

setInterval(beat, BEAT_MS);
setInterval(() => {
  views.look();
  panel.look();
  connection.send({ type: "shown", views: views.painted() });
}, LOOK_MS);
connection.open();

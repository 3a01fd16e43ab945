// The messages between console and page, as far as the page reads them, for the type check of the page's modules.
// The console makes and takes them in `situation.py`, `tools.py`, `frames.py` and `page_messages.py` beside this file, in
// `../hub.py` and `../request_pools.py`, and in `farhand/replay/console.py`.

/** x, y, z: in the base's frame (m) where nothing else is said. */
export type Vector = number[];
/** x, y, z, w. */
export type Quaternion = number[];
export type Axis = "x" | "y" | "z" | "roll" | "pitch" | "yaw";

export interface Pose {
  position: Vector;
  orientation: Quaternion;
}

export interface Joint {
  name: string;
  lower: number;
  upper: number;
  parent_T_joint: Pose;
  axis: Vector;
  slides: boolean;
}

/** `projection` is 3 x 4, row by row, from m to pixels of the full picture; from the tool's frame where `on_tool`. */
export interface Calibration {
  projection: number[];
  on_tool: boolean;
}

export interface Camera {
  name: string;
  width: number;
  height: number;
  calibration: Calibration | null;
}

export interface CalibratedCamera extends Camera {
  calibration: Calibration;
}

export interface Box {
  lower: Vector;
  upper: Vector;
}

export interface Cell {
  cell: string;
  robot: string;
  driver: string;
  joints: Joint[];
  cameras: Camera[];
  held: boolean;
  last_T_tool: Pose;
  workspace_min: Vector;
  workspace_max: Vector;
  shapes: {
    capsules: { link: number; start: Vector; end: Vector; radius: number }[];
    fixtures: Box[];
    gripper: { open: number };
  };
}

/** An operator at a local site; the session in decimal digits. */
export interface Asker {
  name: string;
  session: string;
  words: string;
}

export interface Lease {
  holder: string;
  words: string;
  ours: boolean;
  local_known: boolean;
  asked_by: Asker | null;
}

export interface HandLink {
  age_ms: number | null;
  network_ms: number | null;
  clock_ms: number | null;
  tracking_ms: number | null;
  jitter_ms: number;
  loss: number;
  reason: string;
}

export interface VideoLink {
  carries_mbit_s: number;
  needs_mbit_s: number;
  code: "narrow" | "slow_page" | "busy_host";
}

export interface AssistTarget {
  name: string;
  base_T_marker: Pose;
  size: number;
  base_T_tool: Pose;
  views: string[];
}

export interface Assist {
  phase: "off" | "offered" | "leading" | "ended";
  reason: string;
  target: AssistTarget | null;
}

export interface Gripper {
  opening: number;
  force: number | null;
  status: "moving" | "open" | "closed" | "holding" | "timed_out" | "unknown";
}

export interface Recording {
  writing: boolean;
  on_request: boolean;
  operator_pictures: boolean;
  episode: number;
  episode_open: boolean;
  task: string;
  outcome: "unknown" | "success" | "failure";
  lost: number;
  alarm: string;
  seconds: number;
  size_bytes: number;
  episode_seconds: number;
}

/** The robot's newest state; `heard_ms` is its age since it came, `halted_ns` in decimal digits. */
export interface Robot {
  state: "disengaged" | "engaged" | "holding" | "fault";
  code: string;
  reason: string;
  age_limit_ms: number;
  speed_scale: number;
  q: number[];
  q_commanded: number[];
  base_T_tool: Pose;
  gripper: Gripper | null;
  gripper_next: "open" | "closed" | "keep";
  lease: Lease | null;
  readiness: { ready: boolean; code: string; reason: string };
  min_distance: number | null;
  target: Pose | null;
  hand_link: HandLink | null;
  video_link: VideoLink | null;
  assist: Assist | null;
  recording: Recording | null;
  heard_ms: number;
  silent: boolean;
  halted_ns: string;
}

export interface Hand {
  status: "initialising" | "tracked" | "degraded" | "lost";
  reason: string;
  open: boolean;
  silent: boolean;
}

/** A page's number, and what people call it; both null without one. */
export interface Visitor {
  page: number | null;
  who: string | null;
}

export interface Seat extends Visitor {
  late: boolean;
}

export interface Settings {
  lease: number;
  scale: number;
  rotation_scale: number;
  locks: Record<Axis, boolean>;
}

export interface Clock {
  offset_ms: number | null;
  round_trip_ms: number | null;
}

export type Interval = "command" | "motion" | "encoder" | "picture" | "round_trip" | "uncertainty" | "hand_to_eye";

export interface Figures {
  newest: number | null;
  p50: number | null;
  p95: number | null;
}

export interface Trace {
  seq: number;
  command_ms: number;
  motion_ms: number;
  encoder_ms: number;
  exposed_ms: number;
  shown_ms: number;
}

export interface Event {
  number: number;
  ago_ms: number;
  kind: string;
  text: string;
}

export interface Situation {
  type: "situation";
  now_ms: number;
  robot: Robot | null;
  hand: Hand | null;
  own_recording: Recording | null;
  clock: Clock;
  delay: { loop_ms: number | null; suggested_scale: number };
  seat: Seat;
  settings: Settings | null;
  latency: Record<Interval, Figures>;
  trace: Trace | null;
  unanswered: string | null;
  stopper: Visitor;
  events: Event[];
}

/** A pose with its time by the console's clock. */
export interface TimedPose extends Pose {
  t_ms: number;
}

/** The tool as measured and where it has been sent; `wanted` is where the hand would have it, outside the box too. */
export interface ToolPoses {
  measured: TimedPose | null;
  sent: TimedPose | null;
  wanted: Vector | null;
}

export interface Tools extends ToolPoses {
  type: "tools";
}

export interface ReplayedEvent {
  at_s: number;
  kind: string;
  words: string;
}

export interface Hello {
  type: "hello";
  page: number;
  operate: boolean;
  operator: string;
  remote: string;
  replay: { name: string; began: string; duration_s: number; events: ReplayedEvent[] } | null;
}

export interface Replay {
  type: "replay";
  running: boolean;
  speed: number;
  position_s: number;
  now_ms: number;
  jumps: number;
  trouble: string;
}

export interface Echo {
  type: "echo";
  page_ms: number;
  server_ms: number;
}

export interface CellMessage {
  type: "cell";
  cell: Cell;
}

export interface Answer {
  type: "answer";
  id: number;
  what: string;
  done: boolean;
  reason: string;
}

/** What the console sends as text, by its type. */
export interface Messages {
  hello: Hello;
  replay: Replay;
  echo: Echo;
  cell: CellMessage;
  situation: Situation;
  tools: Tools;
  answer: Answer;
}

/** The header of a binary message: two bytes with its length (little-endian), this as JSON, then the picture, if any. */
export interface PictureHeader {
  view: string;
  seq: number;
  capture_ms: number | null;
  unsure_ms: number | null;
  status: "live" | "dark" | "slow" | "frozen" | "missing";
  reason: string;
  codec: "jpeg" | "h264";
  key: boolean;
}

/** The newest picture of a view that the page has painted. */
export interface Painted {
  seq: number;
  age_ms: number;
  fps: number;
}

/** What a page asks for; the answer has the number of the request, its `id`. */
export type Request =
  | { type: "ask"; action: "stop" }
  | { type: "ask"; action: "engage" | "disengage" | "reset"; seen: string }
  | { type: "ask_lease"; action: "take" | "give"; to?: { name: string; session: string } }
  | { type: "ask_record"; action: "start" | "stop" | "begin" | "end" }
  | { type: "ask_record"; action: "label"; outcome: "success" | "failure" }
  | { type: "mark_joints"; shoulder: number[]; elbow: number[]; wrist: number[] }
  | { type: "take_seat" | "leave_seat" };

/** What a page sends. */
export type PageMessage =
  | { type: "beat"; page_ms: number; heard_ms: number | null; down: boolean; assist: string | null; clutch: "up" | "down" | "unseen" }
  | { type: "taken" | "lost"; view: string }
  | { type: "shown"; h264: boolean; views: Record<string, Painted> }
  | { type: "new_origins" }
  | { type: "play"; playing?: boolean; speed?: number; position_s?: number }
  | { type: "steer"; scale?: number; rotation_scale?: number; locks?: Partial<Record<Axis, boolean>> }
  | (Request & { id: number });

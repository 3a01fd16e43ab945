// The one thing to do next, and what else is possible: for each button next, minor or absent; pure.
// A button that has to wait keeps its place: one that comes and goes would be missed, or another be hit.
const CLUTCH = {
  clutched: "Move your hand to where it has room, let go to go on.",
  clutch_unseen: "Nobody saw the clutch let go: press it again, let go.",
  clutch_settling: "Keep your hand still: the arm follows in a moment.",
};
const BEFORE_CLUTCH = {
  clutched: "Let go of the clutch first.",
  clutch_unseen: "Nobody saw the clutch let go: press it, let go, engage.",
  clutch_settling: "Keep your hand still.",
};
const nothing = (words) => ({ next: null, minor: [], words });

/**
 * Which button is next, whether it has to wait, which are minor, and what to do in words. `act` is what can be done about the lease,
 * `down` whether the key is held here, `blind` whether no view shows the cell.
 */
export function stepOf(condition, situation, { operates, mayOperate, ...facts }) {
  const { robot, seat } = situation;
  if (robot === null) return nothing("Start the robot's side: farhand remote, on its host. If the arm moves, use the emergency stop.");
  if (robot.silent) return nothing("Nothing can be done here until the remote site answers. If the arm moves, use the emergency stop.");
  if (!operates) return watching(seat, mayOperate);
  const step = { ...operating(condition, situation, facts) };
  if (facts.blind) step.words = `No live picture of the cell. ${step.words}`;
  step.minor = [...step.minor, "seat-button"].filter((name) => name !== step.next);
  return step;
}

function watching(seat, mayOperate) {
  if (!mayOperate) return nothing("This console only watches.");
  if (seat.page !== null) return { next: null, minor: ["seat-button"], words: `You watch. ${seat.who} operates.` };
  return { next: "seat-button", minor: [], words: "Nobody operates: take the controls." };
}

function operating(condition, { robot, hand, seat }, { held, act, down }) {
  if (condition.name === "fault" || condition.name === "stopped") return { next: "reset", minor: [], words: "When the cause is gone, reset." };
  if (condition.name === "other") return { next: "lease-button", minor: [], words: "Ask whoever operates to hand over." };
  if (act?.action === "take" && (hand === null || hand.silent)) return nothing("The local site is silent. On this host, type: farhand local");
  if (act?.action === "take") return { next: "lease-button", minor: [], words: "No operator has the robot: take it." };
  if (seat.late) return { next: held ? "hold" : null, minor: ["disengage"], words: "This page's reports come late: close other programs here, then let go and begin again." };
  const handOver = act === null ? [] : ["lease-button"];
  if (robot.state === "disengaged") return disengaged(robot, held, handOver, down);
  const running = { minor: ["disengage", "clutch", "origins", ...handOver] };
  if (condition.name === "clutched") return { ...running, next: held ? "hold" : "clutch", words: CLUTCH[robot.code] };
  if (robot.state === "holding") return { ...running, next: held ? "hold" : null, words: "The arm waits. Show your hand calmly; it goes on by itself." };
  return { ...running, next: held ? "hold" : null, words: followingWords(condition, held) };
}

function followingWords({ name, limit }, held) {
  if (name === "limited") return backWords(limit);
  if (name === "behind") return "The tool is behind your hand: move slowly, or turn it back.";
  if (name === "led") return "The tool moves by itself while you hold Assist.";
  return held ? "Keep it held: the arm follows your hand." : "Move your hand: the arm follows.";
}

/** Only a place pushes back from a direction: the rest has no arrow. */
function backWords(limit) {
  if (limit === "speed limit") return "Move your hand more slowly.";
  return ["workspace", "obstacle", "reach", "leash"].includes(limit) ? "Move your hand back, against the arrow." : "Turn or move your hand back.";
}

function disengaged({ readiness, code }, held, minor, down) {
  if (readiness.code === "robot_not_ready") return { next: "reset", minor, words: "The robot takes no commands: reset it." };
  if (readiness.code in CLUTCH) return { next: "clutch", minor, words: BEFORE_CLUTCH[readiness.code] };
  if (!readiness.ready) return { next: held ? "hold" : "engage", waits: true, minor, words: `Not ready: ${readiness.reason}` };
  if (!held) return { next: "engage", minor, words: "Engage to let the arm follow your hand." };
  const first = down || code === "let_go_first" ? "Let go first. " : "";
  return { next: "hold", minor, words: `${first}Hold to let the arm follow your hand.` };
}

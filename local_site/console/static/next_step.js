// The one thing to do next, and what else is possible: for each button next, minor or absent; pure.
// A button that has to wait keeps its place: one that comes and goes would be missed, or another be hit.
/** @import { Hand, Robot, Seat, Situation } from "../model/messages.d.ts" */
/** @import { Condition } from "./condition.js" */
/** @import { Halt } from "./halt_words.js" */
/** @import { LeaseAct } from "./operators.js" */
import { holderWords } from "./condition.js";
import { EMERGENCY } from "./emergency.js";
import { hasWayBack } from "./limits.js";
import { handTrouble } from "./link_line.js";

/** @typedef {{ next: string | null, waits?: boolean, minor: string[], words: string }} Step */
/** @typedef {{ operator: string, held: boolean, act: LeaseAct | null, down: boolean, stale: string, back: string }} Facts */
/** @typedef {Facts & { operates: boolean, mayOperate: boolean }} PageFacts */

const IF_IT_MOVES = `If the arm moves, ${EMERGENCY}.`;
const UNHEARD = "Press STOP; it may not reach the robot. Have somebody there press the red emergency stop if the arm moves.";
/** @type {Record<string, string>} */
const CLUTCH = {
  clutched: "Move your hand to where it has room, then let go of the clutch: the arm goes on from where it is.",
  clutch_unseen: "Nobody saw the clutch let go: press it again, let go.",
  clutch_settling: "Keep your hand still: the arm follows in a moment.",
};
/** @type {Record<string, string>} */
const BEFORE_CLUTCH = {
  clutched: "Let go of the clutch first.",
  clutch_unseen: "Nobody saw the clutch let go: press it, let go, engage.",
  clutch_settling: "Keep your hand still.",
};
const OF_THE_HAND = ["lost", "initialising", "no_wrist", "uncertain", "no_covariance", "jump", "jumps"];
const READY = { engage: "Press Engage: the arm then follows your hand.", hold: "Hold to let the arm follow your hand." };
const LOCAL_SILENT = "The local site is silent. On this host, type: farhand local";
const MOST_CAUSE = 110; // letters: the bar has the whole sentence
const CURE = /; ((?:check|correct|end|find|give|read|start) [^;]*)$/;
const ONE_NAME = /^\S+$/; // neither several, nor another page, nor the robot's own emergency stop
/** @type {(words: string) => Step} */
const nothing = (words) => ({ next: null, minor: [], words });

/** What to do where the page has lost its console. */
export const lostWords = `${IF_IT_MOVES} Then start farhand console again, on its host.`;

/**
 * Which button is next, whether it has to wait, which are minor, and what to do in words. `operator` is whose page this is, `act` what
 * can be done about the lease, `down` whether the key is held here, `stale` what is wrong with the pictures, `back` in which direction the hand gets back from a limit.
 * @type {(condition: Condition, situation: Situation, facts: PageFacts) => Step}
 */
export function stepOf(condition, situation, { operates, mayOperate, ...facts }) {
  const { robot, seat } = situation;
  if (robot === null) return nothing(`Start the robot's side: type farhand remote, on its host. ${IF_IT_MOVES}`);
  if (robot.silent) return nothing(silentWords(robot));
  if (!operates) return watching(condition, seat, mayOperate);
  const step = { ...operating(condition, robot, situation, facts) };
  if (facts.stale) step.words = `${facts.stale} ${step.words}`;
  step.minor = [...step.minor, "seat-button"].filter((name) => name !== step.next);
  return step;
}

/** @type {(robot: Robot) => string} */
function silentWords({ code }) {
  if (code === "site_ended") return `${UNHEARD} The robot's side was ended: to go on, start it again by farhand remote, on its host.`;
  return `${UNHEARD} Then check the network, and whether farhand remote runs on the robot's host.`;
}

/** @type {(condition: Condition, seat: Seat, mayOperate: boolean) => Step} */
function watching({ halt }, seat, mayOperate) {
  const before = halt === undefined ? "" : `${haltedWords(halt)} `;
  if (!mayOperate) return nothing(`${before}This console only watches.`);
  if (seat.page === null) return { next: "seat-button", minor: [], words: `${before}Nobody operates: take the controls.` };
  const words = before ? `${before}Only the page that operates can reset it.` : "To operate, have the other page leave the controls, then take them here.";
  return { next: null, minor: ["seat-button"], words };
}

/** @type {(condition: Condition, robot: Robot, situation: Situation, facts: Facts) => Step} */
function operating(condition, robot, { hand, seat, clock }, { operator, held, act, down, stale, back }) {
  if (condition.halt !== undefined) return reset(condition.halt, robot, hand, operator);
  if (condition.name === "other" && robot.lease !== null) return { next: "lease-button", minor: [], words: askWords(holderWords(robot.lease, operator), act) };
  if (act?.action === "take" && isSilent(hand)) return nothing(LOCAL_SILENT);
  if (act?.action === "take") return { next: "lease-button", minor: [], words: "No operator has the robot: take it." };
  if (seat.late) return { next: held ? "hold" : null, minor: ["disengage"], words: "This page's reports come late: close other programs here, then let go and begin again." };
  const handOver = act === null ? [] : ["lease-button"];
  const { cure } = handTrouble(robot, clock);
  if (robot.state === "disengaged") return disengaged(robot, { held, down, stale, cure }, handOver);
  const running = { minor: ["disengage", "clutch", "origins", ...handOver] };
  if (condition.name === "clutched") return { ...running, next: held ? "hold" : "clutch", words: CLUTCH[robot.code] };
  if (robot.state === "holding") return { ...running, next: held ? "hold" : null, words: holdingWords(robot, cure) };
  return { ...running, next: held ? "hold" : null, words: followingWords(condition, held, back) };
}

/** @type {(hand: Hand | null) => boolean} */
const isSilent = (hand) => hand === null || hand.silent;

/** A stop or a fault: what it was, and who may reset it, by which button.
 * @type {(halt: Halt, robot: Robot, hand: Hand | null, operator: string) => Step} */
function reset(halt, robot, hand, operator) {
  const what = haltedWords(halt);
  if (robot.lease?.holder === operator) { // at whichever local site
    return { next: "reset", minor: [], words: `${what} ${beforeReset(halt, operator)} press Reset: that alone moves nothing.` };
  }
  if (isSilent(hand)) return nothing(`${what} ${LOCAL_SILENT}`);
  const words = robot.lease === null ? "Take the robot, then reset it." : `Only ${holderWords(robot.lease, operator)} can reset it: ask for the robot to do it yourself.`;
  return { next: "lease-button", minor: [], words: `${what} ${words}` };
}

/** @type {(halt: Halt, operator: string) => string} */
function beforeReset({ who, cause }, operator) {
  if (cause) return `Ask somebody at the robot to ${cureOf(cause) || "put it right"}, then`;
  if (who === "you") return "When it is safe to go on,";
  return `Ask ${ONE_NAME.test(who) && who !== operator ? who : "who stopped it"} whether it is safe to go on, then`;
}

/** What the sentence of a fault tells people to do, which is its end; empty where it tells nothing.
 * @type {(cause: string) => string} */
const cureOf = (cause) => CURE.exec(cause)?.[1] ?? "";

/** @type {(halt: Halt) => string} */
function haltedWords({ who, cause }) {
  const stopped = who === "you" ? "You stopped the arm." : who && `Stopped by ${who}.`;
  return [stopped, cause && `Fault: ${ended(cause.replace(CURE, ""))}`].filter(Boolean).join(" ");
}

/** @type {(sentence: string) => string} */
function ended(sentence) {
  if (sentence.length > MOST_CAUSE) return `${sentence.slice(0, MOST_CAUSE).trimEnd()} …`;
  return /[.?!]$/.test(sentence) ? sentence : `${sentence}.`;
}

/** @type {(holder: string, act: LeaseAct | null) => string} */
function askWords(holder, act) {
  if (act?.isAsked) return `${holder} has been asked: wait until the robot is handed over.`;
  return `To operate yourself, ask ${holder} for the robot.`;
}

/** @type {(robot: Robot, cure: string) => string} */
function holdingWords({ code }, cure) {
  if (OF_THE_HAND.includes(code)) return "Show your hand to the cameras and keep it still: the arm then follows it again.";
  const words = "Keep your hand still: the arm then follows it again.";
  return cure ? `${words} If it goes on holding: ${cure}` : words;
}

/** @type {(condition: Condition, held: boolean, back: string) => string} */
function followingWords({ name, limit }, held, back) {
  if (name === "limited" && limit !== undefined) return backWords(limit, back);
  if (name === "behind") return "The tool is behind your hand: move slowly, or turn it back.";
  if (name === "led") return "The tool moves by itself while you hold Assist.";
  return held ? "Keep it held: the arm follows your hand." : "Move your hand: the arm follows.";
}

/** @type {(limit: string, back: string) => string} */
function backWords(limit, back) {
  if (limit === "speed limit") return "Move your hand more slowly.";
  if (!hasWayBack(limit)) return "Turn or move your hand back the way it came.";
  const where = back ? `back ${back}` : "back the way it came";
  return limit === "leash" ? `Wait for the arm, or move your hand ${where}.` : `Move your hand ${where}: the arm goes no further.`;
}

/** @type {(robot: Robot, facts: Pick<Facts, "held" | "down" | "stale"> & { cure: string }, minor: string[]) => Step} */
function disengaged({ readiness, code }, { held, down, stale, cure }, minor) {
  if (readiness.code === "robot_not_ready") return { next: "reset", minor, words: "The robot takes no commands: reset it." };
  if (readiness.code in CLUTCH) return { next: "clutch", minor, words: BEFORE_CLUTCH[readiness.code] };
  if (!readiness.ready) return { next: held ? "hold" : "engage", waits: true, minor, words: notReady(readiness, cure) };
  const first = held && (down || code === "let_go_first") ? "Let go first. " : "";
  const words = stale ? `Wait for live pictures, or ${held ? "hold" : "engage"} only if you see the arm itself.` : READY[held ? "hold" : "engage"];
  return { next: held ? "hold" : "engage", minor, words: `${first}${words}` };
}

/** @type {(readiness: Robot["readiness"], cure: string) => string} */
function notReady({ code, reason }, cure) {
  const words = `Not ready: ${ended(reason)}`;
  if (code !== "link_too_slow") return words;
  return `${words} ${cure ? `To mend it, ${cure}` : "Take a quicker way: a cable instead of Wi-Fi, no VPN."}`;
}

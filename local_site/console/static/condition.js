// What the arm does, as the page says it at a glance: one condition with its tone, word, second line and sentence; pure.
/** @import { Lease, Robot, Settings, Situation } from "../model/messages.d.ts" */
/** @import { Halt, Whose } from "./halt_words.js" */
import { EMERGENCY } from "./emergency.js";
import { ageWords } from "./freshness.js";
import { haltOf, haltSentence } from "./halt_words.js";
import { distance, turnedBy } from "./kinematics.js";
import { limitOf, limitWords } from "./limits.js";
import { handTrouble } from "./link_line.js";

/** @typedef {{ lost: string, none: (remote: string) => string, noneWord: string, silent: (age: string) => string, unheard: string }} Said */
/** @typedef {{ name: string, tone: string, word: string, second?: string, sentence: string, limit?: string, halt?: Halt }} Condition */

/** @type {Said} */
const LIVE = {
  lost: `the console does not answer, and nothing that you press reaches the arm: if it moves, ${EMERGENCY}`,
  none: (remote) => `nothing has come from the remote site${remote ? ` at ${remote}` : ""} yet`,
  noneWord: "no robot",
  silent: (age) => `the remote site has been silent for ${age}`,
  unheard: "the arm may still move",
};
/** @type {Said} */
const RECORDED = {
  lost: "the program that replays does not answer",
  none: () => "no state is recorded up to here",
  noneWord: "nothing",
  silent: (age) => `no state is recorded for ${age}`,
  unheard: "",
};

// A tool further than this from its target does not do what the hand does; at full speed it lags by less.
const BEHIND_M = 0.06;
const BEHIND_DEG = 20;
const DISENGAGED = /^disengaged, /;
const OF_ITS_AGE = /hand sample is \d+ ms old/;
const ENGAGE_AGAIN = /; engage again to continue$/;

/** The words for what is missing: a page that shows a recording has others.
 * @type {(isReplay: boolean) => Said} */
export const saidOf = (isReplay) => (isReplay ? RECORDED : LIVE);

/** @type {(said: Said) => Condition} */
export const lostCondition = (said) => ({ name: "lost", tone: "fault", word: "no connection", sentence: said.lost });

/** The condition of the newest situation. `whose` is this page's number, its `operator` and the `remote` site's address. A `second` line
 * says more about the word, where there is more; `limit` is the name of the one that holds the arm back, `halt` who has stopped it and
 * what has failed. Before anything has come nothing is wrong.
 * @type {(situation: Situation, whose: Whose, said: Said) => Condition} */
export function conditionOf(situation, whose, said) {
  const { operator, remote } = whose;
  const { robot } = situation;
  if (robot === null) return { name: "none", tone: "idle", word: said.noneWord, sentence: said.none(remote) };
  if (robot.silent) return silent(robot, said);
  if (robot.state === "fault") return halted("fault", robot, situation, whose);
  if (robot.readiness.code === "stopped") return halted("stopped", robot, situation, whose);
  if (robot.lease !== null && isAnothers(robot.lease, operator)) return another(robot, robot.lease, operator);
  return { ...session(robot), sentence: sentenceOf(robot, situation) };
}

/** Whether somebody else may operate; without a hand from the local site its session is not known, but the name is.
 * @type {(lease: Lease | null, operator: string) => boolean} */
export function isAnothers(lease, operator) {
  return lease !== null && !lease.ours && (lease.holder !== operator || lease.local_known);
}

/** Who holds the lease, or asks for it; of two sites under one name, which.
 * @type {(lease: Pick<Lease, "holder" | "words">, operator: string) => string} */
export const holderWords = ({ holder, words }, operator) => (holder === operator ? words : holder);

/** @type {(name: string, robot: Robot, situation: Situation, whose: Whose) => Condition} */
function halted(name, robot, { stopper }, whose) {
  const halt = haltOf(robot.reason, whose, stopper);
  return { name, tone: "fault", word: name, second: "the arm does not follow", sentence: haltSentence(halt), halt };
}

/** @type {(robot: Robot, said: Said) => Condition} */
function silent(robot, said) {
  if (robot.code === "site_ended") return { name: "silent", tone: "fault", word: "ended", sentence: robot.reason };
  return { name: "silent", tone: "fault", word: "silent", second: said.unheard, sentence: said.silent(ageWords(robot.heard_ms)) };
}

/** @type {(robot: Robot, lease: Lease, operator: string) => Condition} */
function another(robot, lease, operator) {
  const who = holderWords(lease, operator);
  const doing = robot.state === "engaged" ? `the arm follows the hand of ${who}` : `the arm rests, and is ${who}'s to move`;
  return { name: "other", tone: "other", word: `${lease.holder} operates`, sentence: `${doing}; your hand moves nothing` };
}

/** @type {(robot: Robot) => Omit<Condition, "sentence">} */
function session(robot) {
  if (robot.state === "holding" && robot.code.startsWith("clutch")) return { name: "clutched", tone: "holding", word: "clutched" };
  if (robot.state === "holding") return { name: "holding", tone: "holding", word: "holding" };
  if (robot.state === "disengaged") return { name: "disengaged", tone: "idle", word: "disengaged" };
  if (robot.assist?.phase === "leading") return { name: "led", tone: "holding", word: "engaged", second: "the assist leads" };
  const limit = limitOf(robot.code);
  if (limit !== null) return { name: "limited", tone: "holding", word: "engaged", second: limitWords(limit), limit };
  if (behindWords(robot)) return { name: "behind", tone: "holding", word: "engaged", second: "behind the hand" };
  return { name: "engaged", tone: "engaged", word: "engaged" };
}

/** How far the tool is from where the hand sends it, empty where that is near.
 * @type {(robot: Robot) => string} */
function behindWords({ target, base_T_tool: tool }) {
  if (target === null) return "";
  const [away, turned] = [distance(target.position, tool.position), turnedBy(target.orientation, tool.orientation)];
  return away > BEHIND_M || turned > BEHIND_DEG ? `the tool is ${(1000 * away).toFixed(0)} mm and ${turned.toFixed(0)}° from its target` : "";
}

/** Which motions of the hand are not copied.
 * @type {(settings: Settings | null) => string} */
function lockWords(settings) {
  const locked = Object.entries(settings?.locks ?? {}).filter(([, on]) => on).map(([axis]) => axis);
  return locked.length > 0 ? `locked: ${locked.join(", ")}` : "";
}

/** Why it is so: what the arm's own causes are. What is wrong with a picture stands on the picture.
 * @type {(robot: Robot, situation: Situation) => string} */
function sentenceOf(robot, { settings, unanswered, clock }) {
  const before = unanswered === null ? [] : [`the remote site has started again, and knows nothing of this any more: ${unanswered}`];
  const behind = limitOf(robot.code) === null ? behindWords(robot) : ""; // a limit has a figure of its own
  const following = robot.state === "engaged" ? [behind, lockWords(settings)] : [];
  const own = robot.state === "disengaged" ? disengagedReasons(robot) : [robot.reason];
  const { words } = handTrouble(robot, clock);
  if (robot.code === "stale" && words) return [...before, words].join(" · "); // the same cause, better known
  return [...before, ...own, ...following, own.some((reason) => OF_ITS_AGE.test(reason)) ? "" : words].filter(Boolean).join(" · ");
}

/** Why it was disengaged, and what is missing before it can be engaged; the word and the next step say the rest.
 * @type {(robot: Robot) => string[]} */
function disengagedReasons({ code, reason, readiness }) {
  if (code === "not_engaged" || readiness.reason === reason) return [readiness.reason];
  return [code === "latched" ? reason.replace(DISENGAGED, "").replace(ENGAGE_AGAIN, "") : reason, readiness.reason];
}

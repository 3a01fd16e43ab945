// What the arm does, as the page says it at a glance: one condition with its tone, word and sentence; pure.
import { ageWords } from "./freshness.js";
import { limitOf } from "./limits.js";
import { troubles } from "./link_line.js";

const LIVE = {
  lost: "the console does not answer: the held key has no effect, and the arm may be moving",
  none: "no state has come from the remote site yet",
  noneWord: "no robot",
  silent: (age) => `the remote site has been silent for ${age}`,
};
const RECORDED = {
  lost: "the program that replays does not answer",
  none: "no state is recorded up to here",
  noneWord: "nothing",
  silent: (age) => `no state is recorded for ${age}`,
};

/** The words for what is missing: a page that shows a recording has others. */
export const saidOf = (isReplay) => (isReplay ? RECORDED : LIVE);

export const lostCondition = (said) => ({ name: "lost", tone: "fault", word: "no connection", sentence: said.lost });

/** The condition of the newest state; `operator` is whose page this is. */
export function conditionOf(robot, operator, said) {
  if (robot === null) return { name: "none", tone: "fault", word: said.noneWord, sentence: said.none };
  if (robot.silent) return silent(robot, said);
  if (robot.state === "fault") return { name: "fault", tone: "fault", word: "fault", sentence: robot.reason };
  if (robot.readiness.code === "stopped") return { name: "stopped", tone: "fault", word: "stopped", sentence: robot.reason };
  if (isAnothers(robot.lease, operator)) return another(robot);
  return { ...session(robot), sentence: sentenceOf(robot) };
}

/** Whether somebody else may operate; without a hand from the local site its session is not known, but the name is. */
export function isAnothers(lease, operator) {
  return lease !== null && !lease.ours && (lease.holder !== operator || lease.local_known);
}

function silent(robot, said) {
  if (robot.code === "site_ended") return { name: "silent", tone: "fault", word: "ended", sentence: robot.reason };
  return { name: "silent", tone: "fault", word: "silent", sentence: said.silent(ageWords(robot.heard_ms)) };
}

function another(robot) {
  const { words } = robot.lease;
  const doing = robot.state === "disengaged" ? "" : ` (${robot.state})`;
  return { name: "other", tone: "other", word: `${robot.lease.holder} operates`, sentence: `${words} operates${doing}; your hand moves nothing` };
}

function session(robot) {
  if (robot.state === "holding") return { name: "holding", tone: "holding", word: "holding" };
  if (robot.state === "disengaged") return { name: "disengaged", tone: "idle", word: "disengaged" };
  if (robot.assist?.phase === "leading") return { name: "led", tone: "holding", word: "assist leads" };
  const limit = limitOf(robot.code);
  return limit === null ? { name: "engaged", tone: "engaged", word: "engaged" } : { name: "limited", tone: "holding", word: limit };
}

function sentenceOf(robot) {
  const missing = robot.state === "disengaged" && robot.readiness.reason !== robot.reason ? [robot.readiness.reason] : [];
  return [robot.reason, ...missing, ...troubles(robot)].join(" · ");
}

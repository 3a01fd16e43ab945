// The way of the hand samples in figures, and what is wrong with the links, as the remote site measures both.
/** @import { Clock, HandLink, Robot } from "../model/messages.d.ts" */
import { element } from "./elements.js";
import { put } from "./words.js";

const ONE_CLOCK_MS = 1;
const LIMIT_AND_PARTS = /; the limit is .*$/; // the figures of the link have the parts
const WHY = {
  narrow: "the link is too narrow",
  slow_page: "this page draws too slowly",
  busy_host: "a machine has too much to do",
};

export class LinkLine {
  #figures = element("link");

  /** @type {(robot: Robot | null) => void} */
  show(robot) {
    const hand = robot === null || robot.silent ? null : robot.hand_link;
    put(this.#figures, robot !== null && hand !== null ? `${figures(hand)}; ${limit(robot)}` : "no samples measured yet");
  }
}

/** Up to which age samples are obeyed, and how fast the arm may be in return.
 * @type {(robot: Robot) => string} */
function limit({ age_limit_ms: ageMs, speed_scale: speed }) {
  return `obeyed up to ${Math.round(ageMs)} ms, at ${Math.round(100 * speed)} % of the speed`;
}

/** Both sites are one machine where their clocks, which count from its start, are one: no link between them is narrow. Of a recording nobody knows.
 * @type {(clock: Clock) => boolean} */
function isOneMachine({ offset_ms: offsetMs, round_trip_ms: roundTripMs }) {
  return offsetMs !== null && roundTripMs !== null && Math.abs(offsetMs) < ONE_CLOCK_MS;
}

/** What is wrong with the way of the hand samples, as the bar says it, and what to do; both empty while nothing is. The list of events has the
 * remote site's whole sentence.
 * @type {(robot: Robot, clock: Clock) => { words: string, cure: string }} */
export function handTrouble({ hand_link: hand, age_limit_ms: limitMs }, clock) {
  if (!hand?.reason) return { words: "", cure: "" };
  const limit = `(limit ${Math.round(limitMs)} ms)`;
  if (isOneMachine(clock) && hand.age_ms !== null) {
    const words = `hand samples are ${Math.round(hand.age_ms)} ms old ${limit}: this machine has too much to do`;
    return { words, cure: "end what else runs on this machine." };
  }
  const [found, cure = ""] = hand.reason.split(/\.? Cure: /);
  return { words: found.replace(LIMIT_AND_PARTS, ` ${limit}`), cure: cure && `${cure.split("; or ")[0]}.` };
}

/** The same of the pictures, for the picture itself.
 * @type {(robot: Robot, clock: Clock) => string} */
export function pictureTrouble({ video_link: video }, clock) {
  if (!video) return "";
  const isSlowPage = video.code === "slow_page";
  const why = !isSlowPage && isOneMachine(clock) ? "this machine has too much to do" : WHY[video.code];
  if (video.code === "busy_host") return `late pictures: ${why}`;
  return `pictures are sent smaller or fewer: ${why} (${video.carries_mbit_s.toFixed(1)} of ${video.needs_mbit_s.toFixed(0)} Mbit/s)`;
}

/** @type {(hand: HandLink) => string} */
function figures({ age_ms: age, network_ms: network, clock_ms: clock, tracking_ms: tracking, ...link }) {
  const parts = [network, clock, tracking].map((ms) => Math.round(ms ?? 0));
  const old = age === null ? "age unknown" : `${Math.round(age)} ms old: network ${parts[0]}, clocks ${parts[1]}, tracking ${parts[2]}`;
  return `${old}; jitter ${Math.round(link.jitter_ms)}, loss ${(100 * link.loss).toFixed(1)} %`;
}

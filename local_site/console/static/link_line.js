// The way of the hand samples in figures, and what is wrong with the links, as the remote site measures both.
import { put } from "./words.js";

export class LinkLine {
  #figures = document.getElementById("link");

  show(robot) {
    const known = robot !== null && !robot.silent && robot.hand_link !== null;
    put(this.#figures, known ? `${figures(robot.hand_link)}; ${limit(robot)}` : "no samples measured yet");
  }
}

/** Up to which age samples are obeyed, and how fast the arm may be in return. */
function limit({ age_limit_ms: ageMs, speed_scale: speed }) {
  return `obeyed up to ${Math.round(ageMs)} ms, at ${Math.round(100 * speed)} % of the speed`;
}

/** The sentences of what is wrong with the links, none while nothing is. */
export function troubles({ hand_link: hand, video_link: video }) {
  return [hand?.reason, video?.reason].filter((sentence) => sentence);
}

function figures({ age_ms: age, network_ms: network, clock_ms: clock, tracking_ms: tracking, ...link }) {
  const parts = [network, clock, tracking].map(Math.round);
  const old = age === null ? "age unknown" : `${Math.round(age)} ms old: network ${parts[0]}, clocks ${parts[1]}, tracking ${parts[2]}`;
  return `${old}; jitter ${Math.round(link.jitter_ms)}, loss ${(100 * link.loss).toFixed(1)} %`;
}

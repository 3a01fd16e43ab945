// The limits that keep the arm from doing what the hand does: the code of each, its short name, and the words for it; pure.
/** @type {Record<string, string>} */
const LIMITS = {
  saturated: "leash",
  out_of_reach: "reach",
  unreached: "reach",
  ik_limit: "joint limit",
  position: "joint limit",
  stance: "posture limit",
  singular: "singular",
  obstacle: "obstacle",
  collision: "obstacle",
  outside_box: "workspace",
  workspace: "workspace",
  velocity: "speed limit",
  acceleration: "speed limit",
  jerk: "speed limit",
  no_trajectory: "no way there",
};

/** @type {Record<string, string>} */
const WORDS = {
  leash: "at the end of its leash",
  reach: "at its reach",
  "joint limit": "at a joint limit",
  "posture limit": "at a posture limit",
  singular: "near a singular posture",
  obstacle: "at an obstacle",
  workspace: "at the workspace's edge",
  "speed limit": "at its speed limit",
  "no way there": "no way there",
};

/** Where an arm is that this limit holds back.
 * @type {(name: string) => string} */
export const limitWords = (name) => WORDS[name] ?? "at a limit";

/** Whether the hand gets back from a limit by moving back: only a place is left in a direction.
 * @type {(name: string) => boolean} */
export const hasWayBack = (name) => ["workspace", "obstacle", "reach", "leash"].includes(name);

/** The name of the limit that a state's code is of; null while the arm follows the hand.
 * @type {(code: string) => string | null} */
export function limitOf(code) {
  return code === "ok" ? null : (LIMITS[code] ?? "limited");
}

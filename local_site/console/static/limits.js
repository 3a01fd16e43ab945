// The limits that keep the arm from doing what the hand does: the code of each with its short name; pure.
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

/** The name of the limit that a state's code is of; null while the arm follows the hand. */
export function limitOf(code) {
  return code === "ok" ? null : (LIMITS[code] ?? "limited");
}

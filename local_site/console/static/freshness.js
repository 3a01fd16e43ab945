// What may be said of a picture: live only if it is young, and told to be; pure.
export const OLD_MS = 300;

/** Mark and words of a view: its newest picture's exposure, what was last told of its camera, and the time, in ms. */
export function judge(newest, told, nowMs) {
  if (newest === null) return { mark: "none", title: "no picture yet", words: told?.reason ?? "" };
  const ageMs = nowMs === null || newest.captureMs === null ? null : nowMs - newest.captureMs;
  if (ageMs === null) return { mark: "old", title: "age unknown", words: "the clocks are not compared yet", ageMs };
  const isOld = ageMs + newest.unsureMs > OLD_MS;
  if (told.status !== "live" && (isOld || told.status !== "slow")) {
    return { mark: told.status, title: `${told.status}, ${ageWords(ageMs)} old`, words: told.reason, ageMs };
  }
  if (isOld) return { mark: "old", title: `${ageWords(ageMs)} old`, words: "no newer picture has come", ageMs };
  return { mark: told.status, title: told.status, words: told.reason, ageMs };
}

/** An age as a person reads it. */
export function ageWords(ms) {
  return ms < 1000 ? `${Math.round(Math.max(0, ms))} ms` : `${(ms / 1000).toFixed(1)} s`;
}

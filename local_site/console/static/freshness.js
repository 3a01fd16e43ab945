// What may be said of a picture: live only if it is young, and told to be; pure.
export const OLD_MS = 300;

/** Mark, words and age of a view, and whether it is old: its newest picture's exposure, what was last told of its camera, and the time, in ms. */
export function judge(newest, told, nowMs) {
  if (newest === null) return { mark: "none", title: "no picture yet", words: told?.reason ?? "", ageMs: null, isOld: true };
  const ageMs = nowMs === null || newest.captureMs === null ? null : nowMs - newest.captureMs;
  if (ageMs === null) return { mark: "old", title: "age unknown", words: "the clocks are not compared yet", ageMs, isOld: true };
  const isOld = ageMs + newest.unsureMs > OLD_MS;
  if (told.status !== "live") {
    const title = isOld ? `${told.status}, ${ageWords(ageMs)} old` : told.status;
    return { mark: told.status, title, words: told.reason, ageMs, isOld };
  }
  if (isOld) return { mark: "old", title: `${ageWords(ageMs)} old`, words: "no newer picture has come", ageMs, isOld };
  return { mark: "live", title: "live", words: "", ageMs, isOld };
}

/** An age as a person reads it. */
export function ageWords(ms) {
  return ms < 1000 ? `${Math.round(Math.max(0, ms))} ms` : `${(ms / 1000).toFixed(1)} s`;
}

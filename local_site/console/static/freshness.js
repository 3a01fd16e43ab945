// The mark of a picture: live only if it is recent and its camera is reported live; pure.
export const OLD_MS = 300;

/** Mark, words and age of a view, and whether it is old: its newest picture's exposure, its camera's last reported status, and the time, in ms. */
export function judge(newest, status, nowMs) {
  if (newest === null) {
    const title = status?.status === "missing" ? "no picture" : "no picture yet";
    return { mark: "none", title, words: status?.reason ?? "", ageMs: null, isOld: true };
  }
  const ageMs = nowMs === null || newest.captureMs === null ? null : nowMs - newest.captureMs;
  if (ageMs === null) return { mark: "old", title: "age unknown", words: "the offset of the clocks is not known yet", ageMs, isOld: true };
  const isOld = ageMs + newest.unsureMs > OLD_MS;
  if (status.status !== "live") {
    const title = isOld ? `${status.status}, ${ageWords(ageMs)} old` : status.status;
    return { mark: status.status, title, words: status.reason, ageMs, isOld };
  }
  if (isOld) return { mark: "old", title: `${ageWords(ageMs)} old`, words: "no newer picture has come", ageMs, isOld };
  return { mark: "live", title: "live", words: "", ageMs, isOld };
}

/** An age as a person reads it. */
export function ageWords(ms) {
  return ms < 1000 ? `${Math.round(Math.max(0, ms))} ms` : `${(ms / 1000).toFixed(1)} s`;
}

// The mark of a picture: live only if it is recent and its camera is reported live; pure.
/** @import { PictureHeader } from "../model/messages.d.ts" */

/** @typedef {{ mark: string, title: string, words: string, ageMs: number | null, isOld: boolean, isLate: boolean }} Judged */
/** @typedef {Pick<PictureHeader, "status" | "reason">} Status */
/** @typedef {{ captureMs: number | null, unsureMs: number, ageMs?: number | null }} Newest */

export const OLD_MS = 300;

/**
 * Mark, words and age of a view, and whether it is old or late now: its newest picture's exposure, and `ageMs` when it was painted, its camera's
 * last reported status, and the time, in ms.
 * Where it `wasLate` a moment ago it still counts as old: a mark that comes and goes is not read.
 * @type {(newest: Newest | null, status: Status | null, nowMs: number | null, wasLate: boolean) => Judged}
 */
export function judge(newest, status, nowMs, wasLate) {
  if (newest === null || status === null) {
    const title = status?.status === "missing" ? "no picture" : "no picture yet";
    return { mark: "none", title, words: status?.reason ?? "", ageMs: null, isOld: true, isLate: false };
  }
  const ageMs = nowMs === null || newest.captureMs === null ? null : nowMs - newest.captureMs;
  if (ageMs === null) return { mark: "old", title: "age unknown", words: "the offset of the clocks is not known yet", ageMs, isOld: true, isLate: false };
  const isLate = ageMs + newest.unsureMs > OLD_MS;
  const isOld = isLate || wasLate;
  if (status.status !== "live") {
    const title = isLate ? `${status.status}, ${ageWords(ageMs)} old` : status.status;
    return { mark: status.status, title, words: status.reason, ageMs, isOld, isLate };
  }
  if (isLate) return { mark: "old", title: `${ageWords(ageMs)} old`, words: lateWords(newest, ageMs), ageMs, isOld, isLate };
  if (isOld) return { mark: "old", title: "late", words: "pictures come late now and then", ageMs, isOld, isLate };
  return { mark: "live", title: "live", words: "", ageMs, isOld, isLate };
}

/** Whether pictures come, but late, or none comes any more.
 * @type {(newest: Newest, ageMs: number) => string} */
function lateWords({ unsureMs, ageMs: paintedMs = null }, ageMs) {
  const cameLate = paintedMs !== null && paintedMs + unsureMs > OLD_MS && ageMs - paintedMs < OLD_MS;
  return cameLate ? "pictures come late" : "no newer picture has come";
}

/** An age as a person reads it.
 * @type {(ms: number) => string} */
export function ageWords(ms) {
  return ms < 1000 ? `${Math.round(Math.max(0, ms))} ms` : `${(ms / 1000).toFixed(1)} s`;
}

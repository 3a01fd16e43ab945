// A picture is live up to 300 ms and no longer, whatever is not known of it counts against it, and an age can be read.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ageWords, judge } from "../../local_site/console/static/freshness.js";

const LIVE = { status: "live", reason: "" };
const at = (captureMs, unsureMs = 0) => ({ captureMs, unsureMs });
const marked = (...facts) => {
  const { mark, title, isOld, isLate } = judge(...facts);
  return [mark, title, isOld, isLate];
};

test("without a picture there is none, with the reason where there is one", () => {
  assert.deepEqual(marked(null, null, 1000, false), ["none", "no picture yet", true, false]);
  const { title, words } = judge(null, { status: "missing", reason: "the camera is not plugged in" }, 1000, false);
  assert.deepEqual([title, words], ["no picture", "the camera is not plugged in"]);
});

test("a picture is live until it is older than 300 ms", () => {
  assert.deepEqual(marked(at(1000), LIVE, 1300, false), ["live", "live", false, false]);
  assert.deepEqual(marked(at(1000), LIVE, 1301, false), ["old", "301 ms old", true, true]);
  assert.deepEqual(marked(at(1000), LIVE, 4200, false), ["old", "3.2 s old", true, true]);
});

test("pictures that come late are told from pictures that come no more", () => {
  const words = (paintedMs, nowMs) => judge({ ...at(1000), ageMs: paintedMs }, LIVE, nowMs, false).words;
  assert.equal(words(480, 1560), "pictures come late");
  assert.equal(words(480, 1800), "no newer picture has come");
  assert.equal(words(60, 1320), "no newer picture has come"); // it came in time, and nothing since
});

test("what the clocks do not know counts as age", () => {
  assert.deepEqual(marked(at(1000, 100), LIVE, 1200, false), ["live", "live", false, false]);
  assert.deepEqual(marked(at(1000, 101), LIVE, 1200, false), ["old", "200 ms old", true, true]);
});

test("an age that is not known is never live", () => {
  assert.deepEqual(marked(at(null), LIVE, 1200, false), ["old", "age unknown", true, false]);
  assert.deepEqual(marked(at(1000), LIVE, null, false), ["old", "age unknown", true, false]);
});

test("a picture that was late a moment ago still counts as old", () => {
  assert.deepEqual(marked(at(1000), LIVE, 1100, true), ["old", "late", true, false]);
});

test("what the camera says of itself comes first, with the age where that is late", () => {
  const frozen = { status: "frozen", reason: "the picture has not changed for 2 s" };
  assert.deepEqual(marked(at(1000), frozen, 1100, false), ["frozen", "frozen", false, false]);
  assert.deepEqual(marked(at(1000), frozen, 3000, false), ["frozen", "frozen, 2.0 s old", true, true]);
  assert.equal(judge(at(1000), frozen, 1100, false).words, frozen.reason);
});

test("ages as they are read", () => {
  assert.deepEqual([-3, 0, 49.6, 999.4, 1000, 2345].map(ageWords), ["0 ms", "0 ms", "50 ms", "999 ms", "1.0 s", "2.3 s"]);
});

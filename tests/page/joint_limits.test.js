// Which joints are near a limit: within 15 degrees, or 15 % of the range of one that slides.
import assert from "node:assert/strict";
import { test } from "node:test";
import { limitWords, nearLimits } from "../../local_site/console/static/joint_limits.js";

const rad = (degrees) => (degrees * Math.PI) / 180;
const CELL = {
  joints: [
    { name: "shoulder", lower: rad(-90), upper: rad(90), slides: false },
    { name: "elbow", lower: rad(-120), upper: rad(120), slides: false },
    { name: "rail", lower: 1, upper: 3, slides: true },
  ],
};
const named = (q) => nearLimits(CELL, q).map(({ joint, way, at }) => [joint, way < 0 ? "down" : "up", at]);

test("no joint in the middle is near", () => {
  assert.deepEqual(nearLimits(CELL, [0, 0, 2]), []);
  assert.equal(limitWords(CELL, [rad(74.9), rad(-104.9), 1.31]), "");
});

test("a joint is near, then at its limit", () => {
  assert.deepEqual(named([rad(75.1), 0, 2]), [[0, "up", false]]);
  assert.deepEqual(named([rad(-86.1), 0, 2]), [[0, "down", true]]);
  assert.deepEqual(named([0, 0, 2.71]), [[2, "up", false]]);
  assert.deepEqual(named([0, 0, 1.07]), [[2, "down", true]]); // 4 % are 80 mm
});

test("the nearest comes first, measured by what is near for its kind", () => {
  assert.deepEqual(named([rad(80), rad(-118), 2.9]).map(([joint]) => joint), [1, 2, 0]); // 2 of 15, 100 of 300 mm, 10 of 15
});

test("words name what is left", () => {
  assert.equal(limitWords(CELL, [rad(80), 0, 2]), "shoulder 10° from its limit");
  assert.equal(limitWords(CELL, [rad(80), rad(-118), 2.9]), "elbow 2°, rail 100 mm, shoulder 10° from their limits");
  assert.equal(limitWords(CELL, [rad(95), 0, 2]), "shoulder 0° from its limit"); // a measured joint may be past it
});

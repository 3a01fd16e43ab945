// Forward kinematics against products and poses that were worked out by hand.
import assert from "node:assert/strict";
import { test } from "node:test";
import { distance, frames, fromPose, inverse, multiply, origin, toolOf, turnedBy } from "../../local_site/console/static/kinematics.js";

const HALF = Math.SQRT1_2; // sine and cosine of 45 degrees: half of a quarter turn
const NONE = [0, 0, 0, 1];
const ABOUT_Z = [0, 0, HALF, HALF];

function close(found, expected) {
  assert.equal(found.length, expected.length);
  found.forEach((v, k) => assert.ok(Math.abs(v - expected[k]) < 1e-12, `${found} is not ${expected}`));
}

test("a product of transforms", () => {
  const a = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 0, 0, 0, 1];
  const b = [2, 0, 1, 3, 1, 1, 0, 2, 0, 4, 1, 1, 0, 0, 0, 1];
  close(multiply(a, b), [4, 14, 4, 14, 16, 34, 12, 42, 28, 54, 20, 70, 0, 0, 0, 1]);
});

test("a quarter turn about z sends x to y, and y to -x", () => {
  close(fromPose({ position: [1, 2, 3], orientation: ABOUT_Z }), [0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1]);
});

const SLANTED = { position: [1, 2, 3], orientation: [0.2, 0.4, 0.4, 0.8] };

test("a turn about no axis of the frame", () => {
  close(fromPose(SLANTED), [0.36, -0.48, 0.8, 1, 0.8, 0.6, 0, 2, -0.48, 0.64, 0.6, 3, 0, 0, 0, 1]);
});

const PLANAR = {
  joints: [
    { axis: [0, 0, 1], slides: false, parent_T_joint: { position: [0, 0, 0.4], orientation: NONE } },
    { axis: [0, 0, 1], slides: false, parent_T_joint: { position: [0.5, 0, 0], orientation: NONE } },
  ],
  last_T_tool: { position: [0.3, 0, 0], orientation: NONE },
};

test("an arm of two links in a plane", () => {
  const straight = frames(PLANAR, [0, 0]).map(origin);
  close(straight.flat(), [0, 0, 0, 0, 0, 0.4, 0.5, 0, 0.4, 0.8, 0, 0.4]);
  const bent = frames(PLANAR, [Math.PI / 2, -Math.PI / 2]); // along y, then along x again
  close(bent.map(origin).flat(), [0, 0, 0, 0, 0, 0.4, 0, 0.5, 0.4, 0.3, 0.5, 0.4]);
  close(toolOf(bent), [1, 0, 0, 0.3, 0, 1, 0, 0.5, 0, 0, 1, 0.4, 0, 0, 0, 1]);
});

test("a joint that slides moves along its axis, as it is turned by the joint before", () => {
  const cell = {
    joints: [
      { axis: [0, 0, 1], slides: false, parent_T_joint: { position: [0, 0, 0], orientation: NONE } },
      { axis: [2 / 7, 3 / 7, 6 / 7], slides: true, parent_T_joint: { position: [0, 0, 0], orientation: NONE } },
    ],
    last_T_tool: { position: [0, 0, 0.1], orientation: NONE },
  };
  close(origin(toolOf(frames(cell, [Math.PI / 2, 0.7]))), [-0.3, 0.2, 0.7]);
});

test("an inverse goes back", () => {
  close(inverse(fromPose({ position: [1, 2, 3], orientation: ABOUT_Z })), [0, 1, 0, -2, -1, 0, 0, 1, 0, 0, 1, -3, 0, 0, 0, 1]);
  close(inverse(fromPose(SLANTED)), [0.36, 0.8, -0.48, -0.52, -0.48, 0.6, 0.64, -2.64, 0.8, 0, 0.6, -2.6, 0, 0, 0, 1]);
});

test("distances and angles between poses", () => {
  assert.equal(distance([1, 2, 3], [3, 5, 9]), 7);
  close([turnedBy(NONE, ABOUT_Z)], [90]);
  close([turnedBy(ABOUT_Z, ABOUT_Z.map((v) => -v))], [0]); // the same orientation
  close([turnedBy(NONE, [0, 0, 1, 0])], [180]);
});

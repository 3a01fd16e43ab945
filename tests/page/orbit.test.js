// The eye of the 3D view: where it is, and that it shows all that it frames.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Orbit, eyeAt, fitted } from "../../local_site/console/static/orbit.js";

const near = (found, expected) => found.forEach((v, k) => assert.ok(Math.abs(v - expected[k]) < 1e-12, `${found} is not ${expected}`));

test("an eye in front of the robot has y to its right and z up", () => {
  const eye = eyeAt(0, 0, 2, [1, 0, 0.5]);
  near(eye.position, [3, 0, 0.5]);
  near(eye.toward, [1, 0, 0]);
  near(eye.right, [0, 1, 0]);
  near(eye.up, [0, 0, 1]);
});

test("an eye a quarter turn to the left and 30 degrees up", () => {
  const eye = eyeAt(Math.PI / 2, Math.PI / 6, 2, [0, 0, 0]);
  near(eye.position, [0, Math.sqrt(3), 1]);
  near(eye.right, [-1, 0, 0]);
  near(eye.up, [0, -0.5, Math.sqrt(3) / 2]);
});

test("what is framed just fits, with a margin of 5 pixels", () => {
  const eye = eyeAt(0, 0, 2, [0, 0, 0]); // at 2 m along x: a metre at x = 0 has half of the scale in pixels
  const wide = fitted(eye, [[0, 0, 0], [0, 1, 0.2]], 410, 300); // 400 pixels wide, 80 high
  near([wide.scale, wide.x, wide.y], [800, 5, 190]);
  const high = fitted(eye, [[0, 0, 0], [0, 0.1, 1]], 410, 300); // 29 pixels wide, 290 high
  near([high.scale, high.x, high.y], [580, 190.5, 295]);
});

test("a workspace and the base are in sight, and touch the margin on both sides in one direction", () => {
  const orbit = new Orbit({ addEventListener() {} }, () => {});
  orbit.show([0.2, -0.5, 0], [1.2, 0.5, 1]);
  const { project } = orbit.sight(640, 480);
  const corners = [0.27, 1.13].flatMap((x) => [-0.43, 0.43].flatMap((y) => [0.07, 0.93].map((z) => [x, y, z]))); // 7 % inside
  const seen = [...corners, [-0.1, -0.1, 0], [0.1, -0.1, 0]].map(project);
  const [left, right] = [Math.min, Math.max].map((most) => most(...seen.map(([x]) => x)));
  const [top, bottom] = [Math.min, Math.max].map((most) => most(...seen.map(([, y]) => y)));
  assert.ok(left > 5 - 1e-6 && right < 635 + 1e-6 && top > 5 - 1e-6 && bottom < 475 + 1e-6);
  assert.ok(right - left > 630 - 1e-6 || bottom - top > 470 - 1e-6);
  assert.ok(project([0.5, 0, 1])[1] < project([0.5, 0, 0])[1]); // what is higher is further up
  assert.equal(project([10, -10, 5]), null); // behind the eye
});

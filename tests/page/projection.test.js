// Where points of the cell are in a picture: a camera with a focal length of 500 pixels and its centre at 320, 240.
import assert from "node:assert/strict";
import { test } from "node:test";
import { clipped, fitted, moved, projected } from "../../local_site/console/static/projection.js";

const AHEAD = [500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]; // it looks along z
const FROM_ABOVE = [500, 0, -320, 640, 0, -500, -240, 480, 0, 0, -1, 2]; // from 2 m above the base, down, the base's x to the right

const pixel = ([u, v, depth]) => [u / depth, v / depth];

test("a point straight ahead is at the centre, others by focal length and depth", () => {
  assert.deepEqual(pixel(projected(AHEAD, [0, 0, 2])), [320, 240]);
  assert.deepEqual(pixel(projected(AHEAD, [0.4, -0.2, 2])), [420, 190]);
  assert.deepEqual(projected(AHEAD, [0.4, -0.2, 2]), [840, 380, 2]);
});

test("a camera that is elsewhere and turned", () => {
  assert.deepEqual(pixel(projected(FROM_ABOVE, [0, 0, 1])), [320, 240]);
  assert.deepEqual(pixel(projected(FROM_ABOVE, [0.2, 0.1, 1])), [420, 190]);
});

test("a point is moved by a transform, or left as it is", () => {
  const quarter = [0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1];
  assert.deepEqual(moved(quarter, [1, 0, 0.5]), [1, 3, 3.5]);
  assert.deepEqual(moved(null, [1, 0, 0.5]), [1, 0, 0.5]);
});

test("a line is cut where it comes too near to the camera", () => {
  assert.deepEqual(clipped([[840, 380, 2], [640, 480, 2]]), [[420, 190], [320, 240]]);
  assert.equal(clipped([[1, 1, 0.01], [1, 1, -3]]), null);
  const [from, to] = clipped([[0, 0, -0.97], [2, 4, 1.03]]); // half of it has a depth of more than 0.03
  assert.ok(Math.abs(from[0] - 1 / 0.03) < 1e-9 && Math.abs(from[1] - 2 / 0.03) < 1e-9);
  assert.deepEqual(to, [2 / 1.03, 4 / 1.03]);
});

test("a picture is as large as it fits, with bars of the same width on both sides", () => {
  const camera = { width: 640, height: 480 };
  assert.deepEqual(fitted([0, 0], camera, 1600, 960), [160, 0]);
  assert.deepEqual(fitted([320, 240], camera, 1600, 960), [800, 480]);
  assert.deepEqual(fitted([640, 480], camera, 320, 400), [320, 320]);
});

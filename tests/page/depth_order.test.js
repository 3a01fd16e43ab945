// The painter's order: what is nearer to the eye is painted over what is behind it. The eye looks along -x from 3 m.
import assert from "node:assert/strict";
import { test } from "node:test";
import { isBehindBox, isBoxBehind, ordered, paintOrder } from "../../local_site/console/static/depth_order.js";

const EYE = { position: [3, 0, 1], toward: [1, 0, 0] };
const BOX = { lower: [0, -0.5, 0], upper: [1, 0.5, 1] };
const capsule = (start, end, more = {}) => ({ start, end, radius: 0.05, ...more });
const BEHIND = capsule([-0.5, 0, 0.2], [-0.5, 0, 0.8]);
const BEFORE = capsule([1.5, 0, 0.2], [1.5, 0, 0.8]);

test("a capsule on the far side of a box is behind it, one on the near side is not, one inside is neither", () => {
  assert.equal(isBehindBox(BEHIND, BOX, EYE.position), true);
  assert.equal(isBehindBox(BEFORE, BOX, EYE.position), false);
  assert.equal(isBehindBox(capsule([0.2, 0, 0.2], [0.8, 0, 0.8]), BOX, EYE.position), null);
  for (const out of [[1.2, 0, 0.5], [0.5, -0.8, 0.5], [0.5, 0, 1.3]]) { // through a face
    assert.equal(isBehindBox(capsule([0.5, 0, 0.5], out), BOX, EYE.position), null);
    assert.equal(isBehindBox(capsule(out, [0.5, 0, 0.5]), BOX, EYE.position), null);
  }
});

test("beside a box the side of the eye decides", () => {
  const beside = capsule([0.5, -1, 0.5], [0.5, -0.8, 0.5]);
  assert.equal(isBehindBox(beside, BOX, [3, 2, 0.5]), true);
  assert.equal(isBehindBox(beside, BOX, [3, -2, 0.5]), false);
});

test("of two faces that have a capsule outside the one that is farther from it decides", () => {
  assert.equal(isBehindBox(capsule([1.1, 0, 1.5], [1.1, 0, 1.5]), BOX, [3, 0, 0.5]), true);
  assert.equal(isBehindBox(capsule([1.5, 0, 1.1], [1.5, 0, 1.1]), BOX, [3, 0, 0.5]), false);
});

test("a capsule over a table is before it for an eye above the top, and behind it for one below", () => {
  const above = capsule([0.2, 0, 1.2], [0.8, 0, 1.3]);
  assert.equal(isBehindBox(above, BOX, [3, 0, 2]), false);
  assert.equal(isBehindBox(above, BOX, [3, 0, 0.5]), true);
});

test("of two boxes the one on the eye's side is not behind", () => {
  const far = { lower: [-2, -0.5, 0], upper: [-1, 0.5, 1] };
  assert.equal(isBoxBehind(far, BOX, EYE.position), true);
  assert.equal(isBoxBehind(BOX, far, EYE.position), false);
  const onTop = { lower: [0, -0.5, 1], upper: [1, 0.5, 2] };
  assert.deepEqual([0.5, 3].map((z) => isBoxBehind(onTop, BOX, [3, 0, z])), [true, false]);
  assert.deepEqual([0.5, 3].map((z) => isBoxBehind(BOX, onTop, [3, 0, z])), [false, true]);
});

test("everything in one order", () => {
  const order = ordered([BEFORE, BEHIND], [BOX], EYE).map(({ capsule: one, box }) => one ?? box);
  assert.deepEqual(order, [BEHIND, BOX, BEFORE]);
});

test("a long table top is painted over what is below it and under what is above it, however far away its middle is", () => {
  const top = { lower: [-3, -0.5, 0.8], upper: [2.5, 0.5, 0.9] };
  const [below, above] = [capsule([2, 0, 0.2], [2, 0, 0.3]), capsule([-2.5, 0, 1.2], [-2.5, 0, 1.3])];
  assert.deepEqual(ordered([below], [top], EYE), [{ capsule: below }, { box: top }]);
  assert.deepEqual(ordered([above], [top], EYE), [{ box: top }, { capsule: above }]);
});

test("of two capsules the one whose surface is nearer comes last", () => {
  const [thick, thin] = [capsule([1, 0, 1], [1, 0, 1], { radius: 0.5 }), capsule([1.2, 0, 1], [1.2, 0, 1])];
  assert.deepEqual(ordered([thick, thin], [], EYE).map((one) => one.capsule), [thin, thick]);
});

test("an inner capsule is painted before all others, as near as it may be", () => {
  const bone = capsule([2, 0, 0.5], [2, 0, 0.6], { inner: true });
  assert.deepEqual(ordered([BEFORE, bone, BEHIND], [], EYE).map((one) => one.capsule), [bone, BEHIND, BEFORE]);
});

test("the farthest comes first, unless another has to precede it", () => {
  assert.deepEqual(paintOrder([1, 3, 2], () => false), [1, 2, 0]);
  assert.deepEqual(paintOrder([1, 3, 2], (a, b) => a === 0 && b === 1), [2, 0, 1]);
});

test("around a circle everything is painted once, the farthest first", () => {
  assert.deepEqual(paintOrder([1, 3, 2], (a, b) => (a + 1) % 3 === b), [1, 2, 0]);
});

// The room below the bar: every view in its shape, nothing on top of anything else, and no room left over where it can be used.
import assert from "node:assert/strict";
import { test } from "node:test";
import { arranged, stacked, waiting } from "../../local_site/console/static/arrangement.js";

const LETTER = 14;
const SHAPES = [4 / 3, 16 / 9, 1, 4 / 3, 16 / 9, 4 / 3, 1, 3 / 2];
const ROOMS = [{ width: 1600, height: 900 }, { width: 1920, height: 1000 }, { width: 1100, height: 1300 }, { width: 2560, height: 900 }];
const close = (a, b) => assert.ok(Math.abs(a - b) < 1e-6, `${a} is not ${b}`);
const areaOf = ({ width, height }) => width * height;

function isInside(box, { width, height }) {
  return box.left > -1e-6 && box.top > -1e-6 && box.left + box.width < width + 1e-6 && box.top + box.height < height + 1e-6;
}

function overlap(a, b) {
  const across = Math.min(a.left + a.width, b.left + b.width) - Math.max(a.left, b.left);
  const down = Math.min(a.top + a.height, b.top + b.height) - Math.max(a.top, b.top);
  return across > 1e-6 && down > 1e-6;
}

function checkApart(boxes) {
  boxes.forEach((a, k) => boxes.slice(k + 1).forEach((b) => assert.ok(!overlap(a, b), JSON.stringify([a, b]))));
}

function checkRoom(shapes, large, room) {
  const { views, side, strip } = arranged(shapes, large, room, LETTER);
  assert.equal(views.length, shapes.length);
  views.forEach(({ width, height }, k) => close(width / height, shapes[k]));
  const boxes = [...views, side, ...(strip === null ? [] : [strip])];
  for (const box of boxes) assert.ok(isInside(box, room), JSON.stringify(box));
  checkApart(boxes);
  if (large !== null) views.forEach((view) => assert.ok(areaOf(view) <= areaOf(views[large]) + 1e-6));
}

for (let count = 1; count <= SHAPES.length; count++) {
  test(`${count} views keep their shapes and do not cover each other, side or strip, and the chosen one is the largest`, () => {
    for (const room of ROOMS) for (const large of [null, 0, count - 1]) checkRoom(SHAPES.slice(0, count), large, room);
  });
}

test("one view is as high as the room, and the side has the rest", () => {
  const { views, side, strip } = arranged([4 / 3], null, { width: 1600, height: 900 }, LETTER);
  assert.deepEqual(views, [{ left: 0, top: 0, width: 1200, height: 900 }]);
  assert.deepEqual(side, { left: 1200, top: 0, width: 400, height: 900 });
  assert.equal(strip, null);
});

test("where pictures are too wide to be as high as the room, the strip is below them", () => {
  const { views, side, strip } = arranged([2], null, { width: 1329, height: 800 }, LETTER); // 23.5 letters are 329
  assert.deepEqual(views, [{ left: 0, top: 0, width: 1000, height: 500 }]);
  assert.deepEqual(side, { left: 1000, top: 0, width: 329, height: 800 });
  assert.deepEqual(strip, { left: 0, top: 500, width: 1000, height: 300 });
});

test("in a high room pictures are as wide as the room, with side and strip below them", () => {
  const { views, side, strip } = arranged([2], null, { width: 1400, height: 1200 }, LETTER);
  assert.deepEqual(views, [{ left: 0, top: 0, width: 1400, height: 700 }]);
  assert.deepEqual(side, { left: 0, top: 700, width: 560, height: 500 });
  assert.deepEqual(strip, { left: 560, top: 700, width: 840, height: 500 });
});

test("of two views in a wide room each is as large as it can be, with nine letters for the strip below them", () => {
  const { views, strip } = arranged([4 / 3, 4 / 3], null, { width: 2560, height: 900 }, LETTER);
  assert.deepEqual(views.map(({ top, height }) => [top, height]), [[0, 774], [0, 774]]);
  close(views[1].left, 1032);
  assert.equal(strip.top, 774);
});

test("beside a chosen view the other one is over the side, as wide as that", () => {
  const { views, side, strip } = arranged([4 / 3, 4 / 3], 1, { width: 1600, height: 900 }, LETTER);
  assert.deepEqual(views[1], { left: 0, top: 0, width: 1200, height: 900 });
  assert.deepEqual(views[0], { left: 1200, top: 0, width: 400, height: 300 });
  assert.deepEqual(side, { left: 1200, top: 300, width: 400, height: 600 });
  assert.equal(strip, null);
});

test("while no view is known the side has 1.6 times its least width, or 0.4 of a narrow room", () => {
  close(waiting({ width: 1600, height: 900 }, LETTER).side.width, 526.4);
  close(waiting({ width: 1000, height: 900 }, LETTER).side.width, 400);
  assert.equal(arranged([], null, { width: 1600, height: 900 }, LETTER).words.height, 98);
});

test("without a view its words, side and strip use all the room", () => {
  const room = { width: 1600, height: 900 };
  for (const { views, side, strip, words } of [arranged([], null, room, LETTER), waiting(room, LETTER)]) {
    assert.deepEqual(views, []);
    const boxes = [side, words, ...(strip === null ? [] : [strip])];
    checkApart(boxes);
    close(boxes.reduce((sum, box) => sum + areaOf(box), 0), 1600 * 900);
  }
});

test("on a page that scrolls views use its whole width, no higher than asked where that can be", () => {
  const { views, height } = stacked([4 / 3, 4 / 3], null, 800, 400);
  assert.deepEqual(views, [{ left: 0, top: 0, width: 400, height: 300 }, { left: 400, top: 0, width: 400, height: 300 }]);
  assert.equal(height, 300);
  close(stacked([4 / 3], null, 800, 400).height, 600); // it cannot be less high
  close(stacked([4 / 3, 4 / 3], null, 800, 1200).height, 1200); // one below the other both are larger
  assert.deepEqual(stacked([], null, 800, 400), { views: [], height: 0 });
});

test("on a page that scrolls the chosen view is the largest", () => {
  const { views } = stacked([1, 4 / 3, 16 / 9], 1, 900, 2000);
  for (const k of [0, 2]) assert.ok(areaOf(views[k]) < areaOf(views[1]));
  checkApart(views);
});

// Mosaics of pictures: each keeps its shape, and together they fill one rectangle.
import assert from "node:assert/strict";
import { test } from "node:test";
import { area, below, beside, mosaics, mosaicsAround, picture } from "../../local_site/console/static/mosaic.js";

const close = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

function checkWhole({ aspect, boxes }, shapes) {
  close(boxes.reduce((sum, box) => sum + area(box), 0), 1);
  boxes.forEach(({ width, height }, k) => close((aspect * width) / height, shapes[k]));
  for (const { left, top, width, height } of boxes) {
    assert.ok(left > -1e-9 && top > -1e-9 && left + width < 1 + 1e-9 && top + height < 1 + 1e-9);
  }
}

test("beside each other a picture has the share of its shape", () => {
  const { aspect, boxes } = beside(picture(4 / 3), picture(2 / 3));
  close(aspect, 2);
  close(boxes[0].width, 2 / 3);
  close(boxes[1].left, 2 / 3);
  assert.deepEqual(boxes.map(({ top, height }) => [top, height]), [[0, 1], [0, 1]]);
});

test("below each other the wider picture is the lower one", () => {
  const { aspect, boxes } = below(picture(2), picture(1));
  close(aspect, 2 / 3); // 2 wide, 1 + 2 high
  close(boxes[0].height, 1 / 3);
  close(boxes[1].top, 1 / 3);
  close(boxes[1].height, 2 / 3);
});

test("all mosaics of up to eight pictures are whole", () => {
  const shapes = [4 / 3, 16 / 9, 1, 4 / 3, 3 / 2, 4 / 3, 1, 2];
  for (let count = 1; count <= shapes.length; count++) {
    const some = shapes.slice(0, count);
    for (const mosaic of [...mosaics(some), ...mosaicsAround(some)]) checkWhole(mosaic, some);
  }
});

test("two pictures can be a row and a column", () => {
  assert.deepEqual(new Set(mosaics([1, 1]).map(({ aspect }) => aspect)), new Set([0.5, 2]));
});

test("three pictures can be a row, a column, two and one, and around the first", () => {
  const aspects = mosaics([1, 1, 1]).map(({ aspect }) => aspect.toFixed(3));
  for (const aspect of ["3.000", "0.333", "0.667", "1.500"]) assert.ok(aspects.includes(aspect), aspects.join());
});

test("around the first one no other is as large", () => {
  for (const { boxes: [first, ...others] } of mosaicsAround([4 / 3, 4 / 3, 4 / 3, 4 / 3])) {
    for (const other of others) assert.ok(area(other) < area(first));
  }
});

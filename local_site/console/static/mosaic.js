// Mosaics of pictures of any shapes: all ways to lay them out as one rectangle, nothing cut off and nothing left black; pure.
/** @typedef {{ left: number, top: number, width: number, height: number }} Area */
/** @typedef {{ aspect: number, boxes: Area[] }} Mosaic boxes are fractions of the whole; `aspect` is width by height */

/** @type {(values: number[]) => number} */
const sum = (values) => values.reduce((total, value) => total + value, 0);

/** A picture by itself; `aspect` is width by height. Boxes are fractions of the whole mosaic.
 * @type {(aspect: number) => Mosaic} */
export const picture = (aspect) => ({ aspect, boxes: [{ left: 0, top: 0, width: 1, height: 1 }] });

/** Mosaics side by side, all as high as the whole.
 * @type {(...blocks: Mosaic[]) => Mosaic} */
export function beside(...blocks) {
  const aspect = sum(blocks.map((block) => block.aspect));
  let left = 0;
  const boxes = blocks.flatMap((block) => {
    const [share, from] = [block.aspect / aspect, left];
    left += share;
    return block.boxes.map((box) => ({ ...box, left: from + share * box.left, width: share * box.width }));
  });
  return { aspect, boxes };
}

/** Mosaics one below the other, all as wide as the whole.
 * @type {(...blocks: Mosaic[]) => Mosaic} */
export function below(...blocks) {
  const turned = beside(...blocks.map(transposed));
  return transposed(turned);
}

/** @type {(mosaic: Mosaic) => Mosaic} */
function transposed({ aspect, boxes }) {
  return { aspect: 1 / aspect, boxes: boxes.map(({ left, top, width, height }) => ({ left: top, top: left, width: height, height: width })) };
}

/** All mosaics of pictures of these shapes, in their order, the larger ones first: in rows, in columns, and around a first, largest one.
 * @type {(aspects: number[]) => Mosaic[]} */
export function mosaics(aspects) {
  const pictures = aspects.map(picture);
  if (pictures.length === 1) return pictures;
  return [...inLines(pictures), ...around(pictures).filter((mosaic) => isFirstLargest(mosaic, 1.01))];
}

/** All mosaics whose first picture is larger than each of the others, which lie beside it, below it, or both.
 * @type {(aspects: number[]) => Mosaic[]} */
export function mosaicsAround(aspects) {
  const [first, ...others] = aspects.map(picture);
  if (others.length === 0) return [first];
  const found = inLines(others).flatMap((rest) => [beside(first, rest), below(first, rest)]);
  return [...found, ...around([first, ...others])].filter((mosaic) => isFirstLargest(mosaic, 0.9));
}

/** Whether no other picture is larger than this share of the first.
 * @type {(mosaic: Mosaic, share: number) => boolean} */
function isFirstLargest({ boxes: [first, ...others] }, share) {
  return others.every((box) => area(box) < share * area(first));
}

/** @type {(box: Pick<Area, "width" | "height">) => number} */
export const area = ({ width, height }) => width * height;

/** In rows, and in columns, of rising numbers of pictures.
 * @type {(pictures: Mosaic[]) => Mosaic[]} */
function inLines(pictures) {
  return partitions(pictures.length).flatMap((counts) => {
    const lines = split(pictures, counts);
    return [below(...lines.map((line) => beside(...line))), beside(...lines.map((line) => below(...line)))];
  });
}

/** The first one large, the others in an angle around it.
 * @type {(pictures: Mosaic[]) => Mosaic[]} */
function around([first, ...others]) {
  return others.slice(1).flatMap((_, k) => {
    const [near, far] = [others.slice(0, k + 1), others.slice(k + 1)];
    return [beside(below(first, beside(...near)), below(...far)), below(beside(first, below(...near)), beside(...far))];
  });
}

/** @type {(pictures: Mosaic[], counts: number[]) => Mosaic[][]} */
function split(pictures, counts) {
  let from = 0;
  return counts.map((count) => pictures.slice(from, (from += count)));
}

/** The ways to write a number as a sum of numbers that do not fall.
 * @type {(count: number, least?: number) => number[][]} */
function partitions(count, least = 1) {
  const found = [[count]];
  for (let part = least; 2 * part <= count; part++) found.push(...partitions(count - part, part).map((rest) => [part, ...rest]));
  return found;
}

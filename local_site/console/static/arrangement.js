// Where pictures, side and strip lie in the room below the bar, so that all of it is used; boxes in pixels; pure.
/** @import { Area, Mosaic } from "./mosaic.js" */
import { area, mosaics, mosaicsAround, picture } from "./mosaic.js";

/** @typedef {{ width: number, height: number }} Size */
/** @typedef {{ views: Area[], side: Area, strip: Area | null, words?: Area }} Arrangement */

// The least that each needs, in multiples of the page's letters.
const SIDE_WIDE = 23.5;
const SIDE_HIGH = 21; // below pictures that stand over it
const STRIP_HIGH = 9; // the arm and the operator's own views, in a row
const FOOT_HIGH = 13; // side and strip, below pictures as wide as the page
const FOOT_SIDE = 0.4; // the side's share of that
const SMALL_WIDE = 9; // a view over the side
const WORDS_HIGH = 7; // why there is no view
const LARGE_COUNTS = 2; // the view that the operator has chosen, against all others together

/**
 * The best arrangement of views of these shapes: `views` are their boxes in the order given, `side` that of the side, `strip` that of the arm and the operator's
 * own views, null where they are in the side. `large` is the number of the view that is to be the largest, null without one.
 * @type {(aspects: number[], large: number | null, room: Size, letter: number) => Arrangement}
 */
export function arranged(aspects, large, room, letter) {
  if (aspects.length === 0) return withoutViews(room, letter);
  const { order, shapes } = ordered(aspects, large);
  const around = large === null ? [] : [...overStrip(mosaicsAround(shapes), room, letter), ...apart(shapes, room, letter)];
  const found = around.length > 0 ? around : overStrip(mosaics(shapes), room, letter);
  const best = found.reduce((a, b) => (worth(b.views, around.length > 0) > worth(a.views, around.length > 0) ? b : a));
  return { ...best, views: inTurn(best.views, order) };
}

/** On a page that scrolls: the boxes of the views over its whole width, no higher together than `most`, where that can be.
 * @type {(aspects: number[], large: number | null, width: number, most: number) => { views: Area[], height: number }} */
export function stacked(aspects, large, width, most) {
  if (aspects.length === 0) return { views: [], height: 0 };
  const { order, shapes } = ordered(aspects, large);
  const around = large === null ? [] : mosaicsAround(shapes);
  const found = (around.length > 0 ? around : mosaics(shapes)).map((mosaic) => ({ height: width / mosaic.aspect, mosaic }));
  const fitting = found.filter(({ height }) => height <= most);
  const lowest = found.reduce((a, b) => (b.height < a.height ? b : a));
  const views = (fitting.length > 0 ? fitting : [lowest]).map(({ height, mosaic }) => placed(mosaic, { left: 0, top: 0, width, height }));
  const best = views.reduce((a, b) => (worth(b, around.length > 0) > worth(a, around.length > 0) ? b : a));
  return { views: inTurn(best, order), height: Math.max(...best.map(({ top, height }) => top + height)) };
}

/** The numbers of the views with the large one first, and their shapes.
 * @type {(aspects: number[], large: number | null) => { order: number[], shapes: number[] }} */
function ordered(aspects, large) {
  const order = aspects.map((_, k) => k);
  if (large !== null) order.unshift(...order.splice(large, 1));
  return { order, shapes: order.map((k) => aspects[k]) };
}

/** @type {(boxes: Area[], order: number[]) => Area[]} */
function inTurn(boxes, order) {
  /** @type {Area[]} */
  const views = [];
  order.forEach((view, k) => (views[view] = boxes[k]));
  return views;
}

/** How good boxes are: a view that is twice as large in place of one that is half as large gains nothing.
 * @type {(boxes: Area[], isLarge: boolean) => number} */
function worth(boxes, isLarge) {
  const [first, ...others] = boxes.map((box) => Math.log(area(box)));
  const rest = others.reduce((total, value) => total + value, 0);
  return isLarge ? LARGE_COUNTS * first + rest / Math.max(1, others.length) : first + rest;
}

/** Mosaics as high as the room, or over the strip, or as wide as the room over side and strip.
 * @type {(found: Mosaic[], room: Size, letter: number) => Arrangement[]} */
function overStrip(found, room, letter) {
  return found.flatMap((mosaic) => {
    const besides = withSide(mosaic, widthOver(mosaic.aspect, room, letter), room);
    return room.width / mosaic.aspect <= room.height - FOOT_HIGH * letter ? [besides, withFoot(mosaic, room)] : [besides];
  });
}

/** How wide pictures of this shape can be beside the side: as high as the room, or else with place for the strip below them.
 * @type {(aspect: number, room: Size, letter: number) => number} */
function widthOver(aspect, { width, height }, letter) {
  const widest = width - SIDE_WIDE * letter;
  return aspect * height <= widest ? aspect * height : Math.min(widest, aspect * Math.max(1, height - STRIP_HIGH * letter));
}

/** A mosaic of this width beside the side, and the strip below it where it is less high than the room.
 * @type {(mosaic: Mosaic, wide: number, room: Size) => Arrangement} */
function withSide(mosaic, wide, { width, height }) {
  const high = wide / mosaic.aspect;
  const strip = height - high < 1 ? null : { left: 0, top: high, width: wide, height: height - high };
  return { views: placed(mosaic, { left: 0, top: 0, width: wide, height: high }), side: { left: wide, top: 0, width: width - wide, height }, strip };
}

/** @type {(mosaic: Mosaic, room: Size) => Arrangement} */
function withFoot(mosaic, { width, height }) {
  const [top, wide] = [width / mosaic.aspect, FOOT_SIDE * width];
  const side = { left: 0, top, width: wide, height: height - top };
  return { views: placed(mosaic, { left: 0, top: 0, width, height: top }), side, strip: { ...side, left: wide, width: width - wide } };
}

/** The first picture as large as the room allows, the others in the side's column over the side.
 * @type {(aspects: number[], room: Size, letter: number) => Arrangement[]} */
function apart([first, ...others], room, letter) {
  if (others.length === 0) return [];
  const { views, side, strip } = withSide(picture(first), widthOver(first, room, letter), room);
  return mosaics(others)
    .map((mosaic) => placed(mosaic, { ...side, height: side.width / mosaic.aspect }))
    .filter((boxes) => boxes.every(({ width }) => width >= SMALL_WIDE * letter))
    .map((boxes) => ({ boxes, high: Math.max(...boxes.map(({ top, height }) => top + height)) }))
    .filter(({ high }) => high <= room.height - SIDE_HIGH * letter)
    .map(({ boxes, high }) => ({ views: [...views, ...boxes], side: { ...side, top: high, height: room.height - high }, strip }));
}

/** Words where the pictures would be, and the strip as large as the room.
 * @type {(room: Size, letter: number) => Arrangement} */
function withoutViews({ width, height }, letter) {
  const { side, words } = waiting({ width, height }, letter);
  const high = WORDS_HIGH * letter;
  return { views: [], side, words: { ...words, height: high }, strip: { ...words, top: high, height: height - high } };
}

/** Words over all the room of the pictures, which nobody knows yet.
 * @type {(room: Size, letter: number) => Arrangement & { words: Area }} */
export function waiting({ width, height }, letter) {
  const wide = width - Math.min(0.4 * width, 1.6 * SIDE_WIDE * letter);
  return { views: [], side: { left: wide, top: 0, width: width - wide, height }, strip: null, words: { left: 0, top: 0, width: wide, height } };
}

/** @type {(mosaic: Mosaic, whole: Area) => Area[]} */
function placed({ boxes }, whole) {
  return boxes.map(({ left, top, width, height }) => ({
    left: whole.left + left * whole.width,
    top: whole.top + top * whole.height,
    width: width * whole.width,
    height: height * whole.height,
  }));
}

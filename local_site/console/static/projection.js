// Where a point of the cell is in a camera's picture, and on the canvas that shows it; pure.
/** @import { Camera, Vector } from "../model/messages.d.ts" */
/** @import { Transform } from "./kinematics.js" */
import { multiply, origin } from "./kinematics.js";

/** @typedef {[number, number]} Pixel across and down */

const NEAREST_M = 0.03; // what is nearer to the camera, or behind it, is clipped

/** A point by a rigid transform; null leaves it as it is.
 * @type {(transform: Transform | null, point: Vector) => Vector} */
export function moved(transform, [x, y, z]) {
  return transform === null ? [x, y, z] : origin(multiply(transform, [1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z, 0, 0, 0, 1]));
}

/** Homogeneous pixels by a 3 x 4 projection: across and down times depth, and depth.
 * @type {(projection: number[], point: Vector) => number[]} */
export function projected(p, [x, y, z]) {
  return [0, 4, 8].map((row) => p[row] * x + p[row + 1] * y + p[row + 2] * z + p[row + 3]);
}

/** The part of a line of homogeneous pixels that is in front of the camera, in pixels; null where none is.
 * @type {(line: number[][]) => Pixel[] | null} */
export function clipped([a, b]) {
  if (a[2] < NEAREST_M && b[2] < NEAREST_M) return null;
  /** @type {(from: number[], to: number[]) => number[]} */
  const cut = (from, to) => {
    if (from[2] >= NEAREST_M) return from;
    const fraction = (NEAREST_M - from[2]) / (to[2] - from[2]);
    return from.map((v, k) => v + fraction * (to[k] - v));
  };
  return [cut(a, b), cut(b, a)].map(([u, v, w]) => [u / w, v / w]);
}

/** Where a pixel of the full picture is on a canvas that shows it as large as it fits.
 * @type {(pixel: Pixel, camera: Pick<Camera, "width" | "height">, width: number, height: number) => Pixel} */
export function fitted([u, v], { width: full, height: tall }, width, height) {
  const scale = Math.min(width / full, height / tall);
  return [(width - scale * full) / 2 + scale * u, (height - scale * tall) / 2 + scale * v];
}

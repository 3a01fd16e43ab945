// Vectors of three numbers; pure.
/** @import { Vector } from "../model/messages.d.ts" */

/** @type {(a: Vector, b: Vector) => Vector} */
export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
/** @type {(a: Vector, b: Vector) => Vector} */
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
/** @type {(a: Vector, s: number) => Vector} */
export const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
/** @type {(a: Vector, b: Vector) => number} */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @type {(a: Vector) => number} */
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
/** @type {(a: Vector, b: Vector) => Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
/** @type {(a: Vector, b: Vector) => Vector} */
export const middle = (a, b) => times(add(a, b), 0.5);

/** The same direction with length 1; a vector of nearly no length becomes `otherwise`.
 * @type {(a: Vector, otherwise?: Vector) => Vector} */
export function unit(a, otherwise = [0, 0, 1]) {
  const size = length(a);
  return size < 1e-6 ? otherwise : times(a, 1 / size);
}

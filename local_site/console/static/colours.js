// Colours of the page made darker and lighter; pure.
/** @typedef {number[]} Colour red, green, blue, 0 to 255 */

/** Red, green and blue of "#rrggbb".
 * @type {(hex: string) => Colour} */
export const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** A colour between two, 0 the first.
 * @type {(a: Colour, b: Colour, share: number) => Colour} */
export const mixed = (a, b, share) => a.map((v, k) => v + share * (b[k] - v));

/** @type {(colour: Colour, alpha?: number) => string} */
export const css = (colour, alpha = 1) => `rgb(${colour.map(Math.round).join(" ")} / ${alpha})`;

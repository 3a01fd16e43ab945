// Colours of the page made darker and lighter; pure.

/** Red, green and blue of "#rrggbb". */
export const rgb = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));

/** A colour between two, 0 the first. */
export const mixed = (a, b, share) => a.map((v, k) => v + share * (b[k] - v));

export const css = (colour, alpha = 1) => `rgb(${colour.map(Math.round).join(" ")} / ${alpha})`;

// What every drawing needs: a canvas as sharp as the screen, the picture's part of it, and the page's colours.
import { fitted } from "./projection.js";

// Reading the size from the canvas itself would make the browser lay out the page before every drawing.
const sizes = new WeakMap();
const observer = new ResizeObserver((entries) => {
  for (const { target, contentRect } of entries) sizes.set(target, contentRect);
});

/** The canvas's size in CSS pixels, with its pixels brought to the screen's. */
export function sized(canvas, context) {
  if (!sizes.has(canvas)) {
    sizes.set(canvas, { width: canvas.clientWidth, height: canvas.clientHeight });
    observer.observe(canvas);
  }
  const { width, height } = sizes.get(canvas);
  const ratio = devicePixelRatio;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width, height };
}

/** Draw only where a camera's picture is on its canvas, not on the bars beside it. */
export function within(context, camera, { width, height }, draw) {
  const [[left, top], [right, bottom]] = [[0, 0], [camera.width, camera.height]].map((pixel) => fitted(pixel, camera, width, height));
  context.save();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
  draw();
  context.restore();
}

/** What a canvas shows, as numbers and words: it is painted again only where that has changed by more than `step`. */
export class LastDrawn {
  #step;
  #key = null;

  constructor(step) {
    this.#step = step;
  }

  /** Whether this is not what the canvas shows; from now on it is. */
  differs(...shown) {
    const key = JSON.stringify(shown, (_, value) => (typeof value === "number" ? Math.round(value / this.#step) : value));
    if (key === this.#key) return false;
    this.#key = key;
    return true;
  }
}

const known = new Map();

/** The page's colours by name, as they are now. */
export function tones(...names) {
  return Object.fromEntries(names.map((name) => [name, tone(name)]));
}

/** One colour of the theme in force; to ask the browser has it work out the page's style first. */
function tone(name) {
  const key = `${document.documentElement.dataset.theme} ${name}`;
  if (!known.has(key)) known.set(key, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return known.get(key);
}

// What every drawing needs: a canvas as sharp as the screen, the picture's part of it, and the page's colours.
/** @import { Camera } from "../model/messages.d.ts" */
/** @import { Size } from "./arrangement.js" */
import { fitted } from "./projection.js";

// Reading the size from the canvas itself would make the browser lay out the page before every drawing.
/** @type {WeakMap<Element, Size>} */
const sizes = new WeakMap();
const observer = new ResizeObserver((entries) => {
  for (const { target, contentRect } of entries) sizes.set(target, contentRect);
});

/** The canvas's size in CSS pixels, with its pixels brought to the screen's.
 * @type {(canvas: HTMLCanvasElement, context: CanvasRenderingContext2D) => Size} */
export function sized(canvas, context) {
  if (!sizes.has(canvas)) {
    sizes.set(canvas, { width: canvas.clientWidth, height: canvas.clientHeight });
    observer.observe(canvas);
  }
  const { width, height } = /** @type {Size} */ (sizes.get(canvas));
  const ratio = devicePixelRatio;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width, height };
}

/** Draw only where a camera's picture is on its canvas, not on the bars beside it.
 * @type {(context: CanvasRenderingContext2D, camera: Camera, size: Size, draw: () => void) => void} */
export function within(context, camera, { width, height }, draw) {
  const [left, top] = fitted([0, 0], camera, width, height);
  const [right, bottom] = fitted([camera.width, camera.height], camera, width, height);
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
  /** @type {string | null} */
  #key = null;

  /** @param {number} step */
  constructor(step) {
    this.#step = step;
  }

  /** Whether this is not what the canvas shows; from now on it is.
   * @type {(...shown: unknown[]) => boolean} */
  differs(...shown) {
    const key = JSON.stringify(shown, (_, value) => (typeof value === "number" ? Math.round(value / this.#step) : value));
    if (key === this.#key) return false;
    this.#key = key;
    return true;
  }
}

/** @type {Map<string, string>} */
const known = new Map();

/** The page's colours by name, as they are now.
 * @type {<K extends string>(...names: K[]) => Record<K, string>} */
export function tones(...names) {
  return /** @type {Record<typeof names[number], string>} */ (Object.fromEntries(names.map((name) => [name, tone(name)])));
}

/** One colour of the theme in force; to ask the browser has it work out the page's style first.
 * @type {(name: string) => string} */
function tone(name) {
  const key = `${document.documentElement.dataset.theme} ${name}`;
  let found = known.get(key);
  if (found === undefined) {
    found = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
    known.set(key, found);
  }
  return found;
}

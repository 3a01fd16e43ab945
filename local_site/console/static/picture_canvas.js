// The canvas of a view's picture, with no more pixels than the screen shows of it.
/** @import { Size } from "./arrangement.js" */

/** @typedef {VideoFrame | ImageBitmap} Picture */

/** How large a decoded picture is to be shown.
 * @type {(picture: Picture) => Size} */
export function sizeOf(picture) {
  if ("displayWidth" in picture) return { width: picture.displayWidth, height: picture.displayHeight };
  return { width: picture.width, height: picture.height };
}

export class PictureCanvas {
  element = document.createElement("canvas");
  isShowing = true; // a canvas always shows what it is given
  isStuck = false;
  #context = /** @type {CanvasRenderingContext2D} */ (this.element.getContext("2d", { alpha: false, desynchronized: true }));
  /** @type {Size} */
  #room = { width: Infinity, height: Infinity };

  constructor() {
    new ResizeObserver(([{ contentRect }]) => (this.#room = contentRect)).observe(this.element);
  }

  /** Paint a decoded picture, an ImageBitmap or a VideoFrame, which is taken over. Without a GPU the browser scales what is larger at each of its frames.
   * @type {(picture: Picture) => void} */
  paint(picture) {
    const { width: full, height: high } = sizeOf(picture);
    const fit = devicePixelRatio * Math.min(this.#room.width / full, this.#room.height / high);
    const scale = fit > 0 && fit < 1 ? fit : 1; // 0 while it is not displayed
    const [width, height] = [full, high].map((size) => Math.round(scale * size));
    if (this.element.width !== width || this.element.height !== height) {
      this.element.width = width;
      this.element.height = height;
      this.#context.imageSmoothingQuality = "low"; // averages what it shrinks to less than half
    }
    this.#context.drawImage(picture, 0, 0, width, height);
    picture.close();
  }

  clear() {
    this.#context.clearRect(0, 0, this.element.width, this.element.height);
  }
}

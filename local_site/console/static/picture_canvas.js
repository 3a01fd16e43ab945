// The canvas of a view's picture, with no more pixels than the screen shows of it.
export class PictureCanvas {
  element = document.createElement("canvas");
  #context = this.element.getContext("2d", { alpha: false, desynchronized: true });
  #room = { width: Infinity, height: Infinity };

  constructor() {
    new ResizeObserver(([{ contentRect }]) => (this.#room = contentRect)).observe(this.element);
  }

  /** Paint a decoded picture: an ImageBitmap or a VideoFrame. Without a GPU the browser scales what is larger at each of its frames. */
  paint(picture) {
    const [full, high] = [picture.displayWidth ?? picture.width, picture.displayHeight ?? picture.height];
    const fit = devicePixelRatio * Math.min(this.#room.width / full, this.#room.height / high);
    const scale = fit > 0 && fit < 1 ? fit : 1; // 0 while it is not displayed
    const [width, height] = [full, high].map((size) => Math.round(scale * size));
    if (this.element.width !== width || this.element.height !== height) {
      this.element.width = width;
      this.element.height = height;
      this.#context.imageSmoothingQuality = "low"; // averages what it shrinks to less than half
    }
    this.#context.drawImage(picture, 0, 0, width, height);
  }

  clear() {
    this.#context.clearRect(0, 0, this.element.width, this.element.height);
  }
}

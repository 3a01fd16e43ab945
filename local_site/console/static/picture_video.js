// A view's picture as a video of the newest one: where no GPU draws, it takes a third less of a processor than a canvas, and not of the page's own thread.
/** @import { Picture } from "./picture_canvas.js" */

const STUCK_MS = 1000;
/** @type {(new (init: { kind: string }) => MediaStreamTrack & { writable: WritableStream<Picture> }) | undefined} */
const Generator = Reflect.get(self, "MediaStreamTrackGenerator"); // of Chromium alone

export class PictureVideo {
  element = document.createElement("video");
  /** @type {WritableStreamDefaultWriter<Picture> | null} */
  #writer = null;
  /** @type {number | null} */
  #pausedMs = null; // since when the browser shows nothing of what it is given

  /** Whether the browser can: one that cannot paints on a canvas. */
  static get isSupported() {
    return Generator !== undefined && "ImageDecoder" in self;
  }

  constructor() {
    this.element.muted = this.element.autoplay = this.element.playsInline = true;
    this.element.disablePictureInPicture = true;
  }

  /** Show a decoded picture, which is taken over.
   * @type {(picture: Picture) => void} */
  paint(picture) {
    this.element.hidden = false;
    this.#writer ??= this.#opened(); // a video without pictures would keep the page from having been loaded
    this.#writer.write(picture);
  }

  /** Whether the browser shows what it is given: where it has paused the video, an old picture would pass for a new one. */
  get isShowing() {
    return !this.element.paused;
  }

  /** Whether it has not been showing it for a second. */
  get isStuck() {
    if (this.isShowing || this.#writer === null || document.hidden) this.#pausedMs = null;
    else this.#pausedMs ??= performance.now();
    return this.#pausedMs !== null && performance.now() - this.#pausedMs > STUCK_MS;
  }

  /** Show none; the next does not begin with the last one. */
  clear() {
    this.element.hidden = true;
    this.element.srcObject = this.#writer = this.#pausedMs = null;
  }

  #opened() {
    const track = new /** @type {NonNullable<typeof Generator>} */ (Generator)({ kind: "video" });
    this.element.srcObject = new MediaStream([track]);
    return track.writable.getWriter();
  }
}

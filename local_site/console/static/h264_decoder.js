// The page's side of the decoding of H.264: chunks go to the worker, decoded pictures come back.
/** @typedef {{ id: number, view: string, key: boolean, bytes: ArrayBuffer, offset: number }} Chunk what the worker gets */
/** @typedef {{ supported: boolean } | { id: number, frame: VideoFrame | null }} Outcome what comes back: first of all whether anything can be decoded */

export class H264Decoder {
  supported = false;
  /** @type {Worker | null} */
  #worker = null;
  #count = 0;
  /** @type {Map<number, (frame: VideoFrame | null) => void>} */
  #waiting = new Map();

  constructor() {
    if (!("VideoDecoder" in self)) return;
    this.#worker = new Worker("/static/h264_worker.js", { type: "module" });
    this.#worker.onmessage = ({ data }) => this.#receive(data);
  }

  /** Decode a view's next picture, the rest of `bytes` from `offset`; null where it cannot be decoded. The bytes are given away.
   * @type {(view: string, key: boolean, bytes: ArrayBuffer, offset: number) => Promise<VideoFrame | null>} */
  decode(view, key, bytes, offset) {
    if (this.#worker === null || !this.supported) return Promise.resolve(null);
    const id = ++this.#count;
    this.#worker.postMessage({ id, view, key, bytes, offset }, [bytes]);
    return new Promise((resolve) => this.#waiting.set(id, resolve));
  }

  /** @type {(outcome: Outcome) => void} */
  #receive(outcome) {
    if ("supported" in outcome) {
      this.supported = outcome.supported;
      return;
    }
    this.#waiting.get(outcome.id)?.(outcome.frame);
    this.#waiting.delete(outcome.id);
  }
}

// The page's side of the decoding of H.264: chunks go to the worker, decoded pictures come back.
export class H264Decoder {
  supported = false;
  #worker = null;
  #count = 0;
  #waiting = new Map();

  constructor() {
    if (!("VideoDecoder" in self)) return;
    this.#worker = new Worker("/static/h264_worker.js", { type: "module" });
    this.#worker.onmessage = ({ data }) => this.#receive(data);
  }

  /** Decode a view's next picture, the rest of `bytes` from `offset`; null where it cannot be decoded. The bytes are given away. */
  decode(view, key, bytes, offset) {
    if (!this.supported) return Promise.resolve(null);
    const id = ++this.#count;
    this.#worker.postMessage({ id, view, key, bytes, offset }, [bytes]);
    return new Promise((resolve) => this.#waiting.set(id, resolve));
  }

  #receive({ id, frame, supported }) {
    if (supported !== undefined) {
      this.supported = supported;
      return;
    }
    this.#waiting.get(id)(frame);
    this.#waiting.delete(id);
  }
}

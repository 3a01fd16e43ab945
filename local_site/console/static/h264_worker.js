// Decodes H.264 in a worker of the page, one decoder for each view; its pictures go to the page without a copy.
/** @import { Chunk } from "./h264_decoder.js" */
import { codecString, parameterSets } from "./h264.js";

const PROBE = "avc1.42E01E"; // constrained baseline, as the cells send it
/** @type {Map<string, ViewDecoder>} */
const views = new Map();

/** One view's decoder: opened anew at every change of the parameter sets, and after an error at the next key frame. */
class ViewDecoder {
  /** @type {VideoDecoder | null} */
  #decoder = null;
  #sets = "";
  /** @type {Set<number>} */
  #waiting = new Set();

  /** @type {(chunk: Chunk) => void} */
  decode({ id, key, bytes, offset }) {
    this.#waiting.add(id);
    const data = new Uint8Array(bytes, offset);
    try {
      if (key) this.#open(data);
      if (this.#decoder === null) this.#fail(); // no key frame yet
      else this.#decoder.decode(new EncodedVideoChunk({ type: key ? "key" : "delta", timestamp: id, data }));
    } catch {
      this.#fail(); // no key frame after all
    }
  }

  /** @type {(data: Uint8Array) => void} */
  #open(data) {
    const sets = parameterSets(data);
    if (this.#decoder !== null && sets.join() === this.#sets) return;
    this.#sets = sets.join();
    this.#decoder ??= new VideoDecoder({ output: (frame) => this.#give(frame), error: () => this.#fail() });
    this.#decoder.configure({ codec: codecString(sets), optimizeForLatency: true });
  }

  /** @type {(frame: VideoFrame) => void} */
  #give(frame) {
    const id = frame.timestamp;
    this.#waiting.delete(id);
    postMessage({ id, frame }, [frame]);
  }

  /** Nothing more comes of what waits in the decoder. */
  #fail() {
    if (this.#decoder !== null && this.#decoder.state !== "closed") this.#decoder.close();
    this.#decoder = null;
    for (const id of this.#waiting) postMessage({ id, frame: null });
    this.#waiting.clear();
  }
}

self.onmessage = ({ data }) => {
  const view = views.get(data.view) ?? new ViewDecoder();
  views.set(data.view, view);
  view.decode(data);
};

const supported = "VideoDecoder" in self && (await VideoDecoder.isConfigSupported({ codec: PROBE, optimizeForLatency: true })).supported;
postMessage({ supported });

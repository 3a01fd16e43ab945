// H.264 in Annex B: the parameter sets of a key frame, and the codec's name that they give; pure.
const SPS = 7;
const PPS = 8;
const TYPE = 0x1f;

/** The sequence and picture parameter sets at the beginning of a key frame, in the order in which they come.
 * @type {(data: Uint8Array) => Uint8Array[]} */
export function parameterSets(data) {
  /** @type {number[]} */
  const starts = [];
  for (let k = 0; k + 3 < data.length; k++) {
    if (data[k] === 0 && data[k + 1] === 0 && data[k + 2] === 1) {
      starts.push(k + 3);
      if (![SPS, PPS].includes(data[k + 3] & TYPE)) break;
      k += 3;
    }
  }
  return starts.slice(0, -1).map((start, k) => data.slice(start, starts[k + 1] - 3)).filter((unit) => [SPS, PPS].includes(unit[0] & TYPE));
}

/** The codec's name for the browser, from profile, constraints and level in the first parameter set (RFC 6381).
 * @type {(sets: Uint8Array[]) => string} */
export function codecString([sps]) {
  return `avc1.${[...sps.slice(1, 4)].map((byte) => byte.toString(16).padStart(2, "0")).join("")}`;
}

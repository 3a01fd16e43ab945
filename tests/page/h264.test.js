// The parameter sets at the beginning of a key frame in Annex B, and the codec's name of RFC 6381.
import assert from "node:assert/strict";
import { test } from "node:test";
import { codecString, parameterSets } from "../../local_site/console/static/h264.js";

const SPS = [0x67, 0x42, 0xe0, 0x0d, 0x00, 0x05, 0x01, 0xaa]; // begin codes but for a byte are none
const PPS = [0x68, 0xce, 0x02, 0x00, 0x01, 0x3c];
const SLICE = [0x65, 0x88, 0x84, 0x00];
const START = [0, 0, 1];
const found = (...bytes) => parameterSets(Uint8Array.from(bytes.flat())).map((set) => [...set]);

test("both sets of a key frame, in their order, without what follows", () => {
  assert.deepEqual(found(START, SPS, START, PPS, START, SLICE), [SPS, PPS]);
});

test("no set in a frame that begins with its slice", () => {
  assert.deepEqual(found(START, SLICE, START, SPS), []);
  assert.deepEqual(found([]), []);
});

test("profile, constraints and level are the codec's name", () => {
  assert.equal(codecString([Uint8Array.from(SPS)]), "avc1.42e00d");
});

// A binary message: the length of its header in two bytes, the header as JSON, then the picture.
import assert from "node:assert/strict";
import { test } from "node:test";
import { parsePicture } from "../../local_site/console/static/picture.js";

function message(header, picture) {
  const json = new TextEncoder().encode(header);
  return Uint8Array.from([json.length & 255, json.length >> 8, ...json, ...picture]).buffer;
}

test("header and where the picture begins", () => {
  const { header, offset, isPicture } = parsePicture(message('{"view":"camera/träger","seq":7}', [1, 2, 3]));
  assert.deepEqual(header, { view: "camera/träger", seq: 7 });
  assert.equal(offset, 2 + 33); // ä has two bytes
  assert.ok(isPicture);
});

test("a header longer than 255 bytes", () => {
  const reason = "x".repeat(300);
  const { header, offset } = parsePicture(message(`{"reason":"${reason}"}`, [1]));
  assert.equal(header.reason, reason);
  assert.equal(offset, 2 + 313);
});

test("without a picture it is a status only", () => {
  assert.equal(parsePicture(message('{"status":"missing"}', [])).isPicture, false);
});

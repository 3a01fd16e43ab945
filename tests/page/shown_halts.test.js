// A reset names only a halt that was shown for long enough to be read: half a second.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ShownHalts } from "../../local_site/console/static/shown_halts.js";

test("a halt can have been read after half a second, not before", () => {
  const halts = new ShownHalts();
  assert.deepEqual([halts.newest, halts.readBy(0)], ["0", "0"]);
  halts.show("7", 1000);
  assert.deepEqual([halts.newest, halts.readBy(1499)], ["7", "0"]);
  halts.show("7", 1400); // the same state again changes nothing
  assert.equal(halts.readBy(1500), "7");
});

test("of halts in quick succession the last one that could be read counts", () => {
  const halts = new ShownHalts();
  halts.show("7", 1000);
  halts.show("8", 1600);
  assert.equal(halts.readBy(1700), "7");
  halts.show("9", 1800); // 8 was seen for 200 ms
  assert.equal(halts.readBy(2299), "7");
  assert.equal(halts.readBy(2300), "9");
});

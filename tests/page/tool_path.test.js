// Where the tool was when a picture was taken: the nearest measured pose, at most 80 ms away, of the last three seconds.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ToolPath } from "../../local_site/console/static/tool_path.js";

function path(...times) {
  const made = new ToolPath();
  for (const t_ms of times) made.add({ t_ms, position: [t_ms, 0, 0], orientation: [0, 0, 0, 1] });
  return made;
}

test("the nearest pose counts", () => {
  const made = path(1000, 1050, 1100);
  assert.equal(made.at(1070)?.t_ms, 1050);
  assert.equal(made.at(1080)?.t_ms, 1100);
});

test("none is near in a gap, before the first or after the last", () => {
  const made = path(1000, 1300);
  assert.equal(made.at(1080)?.t_ms, 1000);
  assert.equal(made.at(1081), null);
  assert.equal(made.at(919), null);
  assert.equal(made.at(1381), null);
  assert.equal(path().at(1000), null);
});

test("poses are kept for three seconds, and one that comes again or late is not kept", () => {
  const made = path(1000, 2000, 1500, 4001);
  assert.equal(made.at(1000), null);
  assert.equal(made.at(1500), null);
  assert.equal(made.at(2000)?.t_ms, 2000);
});

test("after poses of another clock, far in the past, the path begins again", () => {
  const made = path(50_000, 50_050, 1000, 1050);
  assert.equal(made.at(1000)?.t_ms, 1000);
  assert.equal(made.at(50_050), null);
});

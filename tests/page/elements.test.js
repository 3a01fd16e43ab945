// Elements that modules ask for by their id are in index.html, and of the kind that is asked for.
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { test } from "node:test";

const STATIC = new URL("../../local_site/console/static/", import.meta.url);
const read = (name) => readFileSync(new URL(name, STATIC), "utf8");
const kinds = new Map([...read("index.html").matchAll(/<(\w+)[^>]*?\sid="([^"]+)"/g)].map(([, tag, id]) => [id, tag]));

for (const name of readdirSync(STATIC).filter((file) => file.endsWith(".js"))) {
  const asked = [...read(name).matchAll(/\b(?:element|tagged)\((?:"(\w+)", )?"([^"]+)"\)/g)];
  if (asked.length === 0) continue;
  test(name, () => {
    for (const [, kind, id] of asked) {
      assert.ok(kinds.has(id), `no element ${id}`);
      if (kind !== undefined) assert.equal(kinds.get(id), kind, id);
    }
  });
}

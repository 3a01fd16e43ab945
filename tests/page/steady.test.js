// The condition that is shown: a worse one at once, a better one after 600 ms, and what stopped the arm until it is answered.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Steady } from "../../local_site/console/static/steady.js";

const of = (name) => ({ name, tone: "", word: name, sentence: `it is ${name}` });

test("a worse condition shows at once", () => {
  const steady = new Steady();
  const names = [of("engaged"), of("limited"), of("holding"), of("fault")].map((one, k) => steady.show(one, k).name);
  assert.deepEqual(names, ["engaged", "limited", "holding", "fault"]);
});

test("a better one has to last", () => {
  const steady = new Steady();
  steady.show(of("holding"), 0);
  assert.equal(steady.show(of("engaged"), 100).name, "holding");
  assert.equal(steady.show(of("engaged"), 699).name, "holding");
  assert.equal(steady.show(of("engaged"), 700).name, "engaged");
});

test("one that comes and goes is not shown, however often", () => {
  const steady = new Steady();
  steady.show(of("holding"), 0);
  for (let ms = 100; ms < 3000; ms += 400) {
    assert.equal(steady.show(of("engaged"), ms).name, "holding");
    assert.equal(steady.show(of("holding"), ms + 200).name, "holding");
  }
});

test("the first cause stays while nothing is heard, and goes with an answer", () => {
  const steady = new Steady();
  steady.show(of("stopped"), 0);
  const silent = steady.show(of("silent"), 100);
  assert.equal(silent.name, "silent");
  assert.equal(silent.word, "stopped");
  assert.equal(silent.sentence, "it is stopped · then: it is silent");
  assert.equal(steady.show(of("lost"), 200).word, "stopped");
  assert.equal(steady.show(of("disengaged"), 300).word, "disengaged");
  assert.equal(steady.show(of("silent"), 400).word, "silent");
});

// The console's clock on the page: by the quickest echo of the last four seconds, over a suspend, and in a replay.
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { ServerClock } from "../../local_site/console/static/server_clock.js";

const host = { pageMs: 0, wallMs: 0 };
performance.now = () => host.pageMs;
Date.now = () => host.wallMs;

beforeEach(() => {
  Object.assign(host, { pageMs: 1000, wallMs: 1_700_000_000_000 });
});

function pass(ms) {
  host.pageMs += ms;
  host.wallMs += ms;
}

test("before the first echo the time is not known", () => {
  assert.equal(new ServerClock().now(), null);
});

test("an echo was answered in the middle of its way", () => {
  const clock = new ServerClock();
  clock.add(1000, 5020, 1040); // 4000 ms ahead at 1020
  host.pageMs = 1100;
  assert.equal(clock.now(), 5100);
});

test("the echo that took least counts, in whichever second it came", () => {
  const clock = new ServerClock();
  clock.add(1000, 5020, 1040);
  clock.add(1100, 5200, 1500); // 200 ms on the way, and would say 3900 ms ahead
  clock.add(2000, 6103, 2010); // 10 ms on the way: 4098 ms ahead
  clock.add(3000, 7000, 3400);
  host.pageMs = 4000;
  assert.equal(clock.now(), 8098);
});

test("of one second the echo that took least is kept", () => {
  const clock = new ServerClock();
  clock.add(1000, 5020, 1040);
  clock.add(1100, 5210, 1120); // 4100 ms ahead
  clock.add(1200, 5300, 1900);
  host.pageMs = 1950;
  assert.equal(clock.now(), 6050);
});

test("an echo counts for four seconds with echoes", () => {
  const clock = new ServerClock();
  clock.add(1000, 5005, 1010); // 4000 ms ahead
  for (const k of [2, 3, 4]) clock.add(1000 * k, 1000 * k + 4550, 1000 * k + 100); // 4500 ms ahead
  host.pageMs = 4200;
  assert.equal(clock.now(), 8200);
  clock.add(5000, 9550, 5100);
  assert.equal(clock.now(), 8700);
});

test("a suspend is what the wall clock went on while the page's stood, once; less than a second is none", () => {
  const clock = new ServerClock();
  pass(500);
  assert.equal(clock.suspendedMs, 0);
  host.wallMs += 900;
  assert.equal(clock.suspendedMs, 0);
  host.wallMs += 60_000;
  assert.equal(clock.suspendedMs, 60_000);
  pass(500);
  assert.equal(clock.suspendedMs, 60_000);
});

test("a replay's time goes on at its speed, and stands where it is paused", () => {
  const clock = new ServerClock();
  clock.follow(70_000, 2);
  assert.ok(clock.isReplayed && !clock.isStanding);
  pass(300);
  assert.equal(clock.now(), 70_600);
  clock.follow(70_600, 0);
  pass(300);
  assert.equal(clock.now(), 70_600);
  assert.ok(clock.isStanding);
});

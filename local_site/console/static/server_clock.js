// The console's clock as the page knows it: by the echo with the shortest round trip of the last seconds.
/** @typedef {{ tookMs: number, offsetMs: number, slot: number }} Trip */

const SLOTS = 4;
const SLOT_MS = 1000;
const SUSPENDED_MS = 1000; // of difference between the wall clock and the page's own: no less is a suspend

export class ServerClock {
  /** @type {Trip[]} */
  #best = [];
  /** @type {{ nowMs: number, speed: number, heardMs: number } | null} */
  #replayed = null;
  #apartMs = Date.now() - performance.now();
  #suspendedMs = 0;

  /** Follow a recording's time, which goes on at a speed, instead of the console's.
   * @type {(nowMs: number, speed: number) => void} */
  follow(nowMs, speed) {
    this.#replayed = { nowMs, speed, heardMs: performance.now() };
  }

  /** Whether the time is a recording's. */
  get isReplayed() {
    return this.#replayed !== null;
  }

  /** Whether the recording is paused. */
  get isStanding() {
    return this.#replayed?.speed === 0;
  }

  /** How long this host was suspended so far, in ms: the page's own clock, and the console's, stand still then. Read it often. */
  get suspendedMs() {
    const apartMs = Date.now() - performance.now();
    if (apartMs - this.#apartMs > SUSPENDED_MS) this.#suspendedMs += apartMs - this.#apartMs;
    this.#apartMs = apartMs;
    return this.#suspendedMs;
  }

  /** Add an echo: sent and received by the page's clock, answered by the console's, all in ms.
   * @type {(sentMs: number, answeredMs: number, receivedMs: number) => void} */
  add(sentMs, answeredMs, receivedMs) {
    const trip = { tookMs: receivedMs - sentMs, offsetMs: answeredMs - (sentMs + receivedMs) / 2, slot: Math.floor(receivedMs / SLOT_MS) };
    const last = this.#best.at(-1);
    if (last === undefined || last.slot !== trip.slot) this.#best.push(trip);
    else if (trip.tookMs < last.tookMs) this.#best[this.#best.length - 1] = trip;
    this.#best = this.#best.slice(-SLOTS);
  }

  /** The console's time in ms; null before the first echo.
   * @type {() => number | null} */
  now() {
    if (this.#replayed !== null) return this.#replayed.nowMs + (performance.now() - this.#replayed.heardMs) * this.#replayed.speed;
    if (this.#best.length === 0) return null;
    const quickest = this.#best.reduce((a, b) => (b.tookMs < a.tookMs ? b : a));
    return performance.now() + quickest.offsetMs;
  }
}

// The link's round trip in the header, the marks' legend with the age of each, and the scale suggested for the delay.
/** @import { Situation, ToolPoses } from "../model/messages.d.ts" */
/** @import { ServerClock } from "./server_clock.js" */
import { element } from "./elements.js";
import { ageWords } from "./freshness.js";
import { mark, put } from "./words.js";

const UNKNOWN = "–";

export class DelayPanel {
  #clock;
  /** @type {number | null} */
  #suggested = null;

  /** `take` sets the scale that is suggested.
   * @param {ServerClock} clock @param {(scale: number) => void} take */
  constructor(clock, take) {
    this.#clock = clock;
    element("suggestion").addEventListener("click", () => this.#suggested !== null && take(this.#suggested));
  }

  /** The situation's part of it, and the tools that the marks show.
   * @type {(situation: Situation, tools: ToolPoses) => void} */
  show({ robot, clock: { round_trip_ms: roundTripMs }, delay, settings }, tools) {
    const answers = robot !== null && !robot.silent;
    put(element("round-trip"), answers && roundTripMs !== null ? `${roundTripMs.toFixed(0)} ms` : UNKNOWN);
    put(element("loop"), answers && delay.loop_ms !== null ? `${delay.loop_ms.toFixed(0)} ms` : UNKNOWN);
    this.#suggested = delay.suggested_scale;
    const isLess = settings !== null && delay.suggested_scale < settings.scale;
    mark(element("suggestion"), "data-offered", isLess);
    put(element("suggestion"), `delay: use ${delay.suggested_scale.toFixed(2)}`);
    this.#age(tools);
  }

  /** @type {(tools: ToolPoses) => void} */
  #age({ measured, sent }) {
    for (const { id, tool } of [{ id: "measured-age", tool: measured }, { id: "sent-age", tool: sent }]) {
      const nowMs = this.#clock.now();
      put(element(id), tool === null || nowMs === null ? UNKNOWN : `${ageWords(nowMs - tool.t_ms)} ago`);
    }
  }

  disconnected() {
    for (const id of ["round-trip", "loop", "measured-age", "sent-age"]) put(element(id), UNKNOWN);
  }
}

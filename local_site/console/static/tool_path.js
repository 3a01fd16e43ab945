// The measured tool of the last seconds, to look up where it was when a picture was taken; pure.
/** @import { TimedPose } from "../model/messages.d.ts" */

const KEPT_MS = 3000;
const APART_MS = 80; // between a measured pose and the time that is asked for, at most

export class ToolPath {
  /** @type {TimedPose[]} */
  #poses = [];

  /** Add a measured pose with its time in ms; the same one again is not kept twice. One that is older than all that
   * is kept has been told by another clock, as after a restart: the path begins again with it.
   * @type {(tool: TimedPose) => void} */
  add(tool) {
    const last = this.#poses.at(-1);
    if (last !== undefined && last.t_ms - KEPT_MS > tool.t_ms) this.#poses = [];
    else if (last !== undefined && last.t_ms >= tool.t_ms) return;
    this.#poses.push(tool);
    while (this.#poses[0].t_ms < tool.t_ms - KEPT_MS) this.#poses.shift();
  }

  /** The pose nearest to a time; null where none is near.
   * @type {(timeMs: number) => TimedPose | null} */
  at(timeMs) {
    /** @type {TimedPose | null} */
    let nearest = null;
    for (const tool of this.#poses) {
      if (nearest === null || Math.abs(tool.t_ms - timeMs) < Math.abs(nearest.t_ms - timeMs)) nearest = tool;
    }
    return nearest !== null && Math.abs(nearest.t_ms - timeMs) <= APART_MS ? nearest : null;
  }
}

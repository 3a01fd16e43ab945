// The outline of a posture: what surrounds all of its capsules, as if they were one body.
/** @import { Capsule } from "./arm_solids.js" */
/** @import { Project, Sight } from "./orbit.js" */
import { seenCapsule, traceCapsule } from "./capsule_shading.js";

const LINE_PX = 1.8;

export class PostureOutline {
  #layer = new OffscreenCanvas(1, 1);
  #context = /** @type {OffscreenCanvasRenderingContext2D} */ (this.#layer.getContext("2d"));

  /** Draw it over a canvas: a line around it, and a trace of its tone inside.
   * @type {(context: CanvasRenderingContext2D, sight: Sight, capsules: Capsule[], tone: string) => void} */
  draw(context, sight, capsules, tone) {
    const path = outlined(capsules, sight.project);
    if (this.#layer.width !== context.canvas.width || this.#layer.height !== context.canvas.height) {
      [this.#layer.width, this.#layer.height] = [context.canvas.width, context.canvas.height];
    }
    const layer = this.#context;
    layer.setTransform(context.getTransform());
    layer.clearRect(0, 0, this.#layer.width, this.#layer.height);
    layer.strokeStyle = layer.fillStyle = tone;
    layer.lineWidth = 2 * LINE_PX;
    layer.lineJoin = "round";
    layer.stroke(path);
    layer.globalCompositeOperation = "destination-out";
    layer.fill(path);
    layer.globalCompositeOperation = "source-over";
    layer.globalAlpha = 0.22;
    layer.fill(path);
    layer.globalAlpha = 1;
    context.save();
    context.resetTransform();
    context.drawImage(this.#layer, 0, 0);
    context.restore();
  }
}

/** @type {(capsules: Capsule[], project: Project) => Path2D} */
function outlined(capsules, project) {
  const path = new Path2D();
  for (const capsule of capsules) {
    const seen = seenCapsule(capsule, project);
    if (seen !== null) traceCapsule(path, seen);
  }
  return path;
}

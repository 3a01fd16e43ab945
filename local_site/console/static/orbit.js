// The camera of the 3D view: turned by mouse, touch or arrow keys; projects points to the canvas.
const STEP = 0.12;
const ZOOM = 1.1;
const ROOM = 1.55; // distance of the eye relative to the size of the scene

export class Orbit {
  #yaw = -0.9;
  #pitch = 0.35;
  #distance = 2.3;
  #center = [0.25, 0, 0.45];
  #known = false;

  constructor(canvas, changed) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      this.#turn(-event.movementX * 0.008, event.movementY * 0.008);
      changed();
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.#zoom(event.deltaY > 0 ? ZOOM : 1 / ZOOM);
      changed();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => this.#key(event) && (event.preventDefault(), changed()));
  }

  /** Frame a box (m) and the base, the first time that it is known. */
  show(low, high) {
    if (this.#known) return;
    this.#known = true;
    const [from, to] = [low.map((v) => Math.min(v, 0)), high.map((v) => Math.max(v, 0))];
    this.#center = from.map((v, axis) => (v + to[axis]) / 2);
    this.#distance = ROOM * Math.hypot(...from.map((v, axis) => to[axis] - v));
  }

  #key({ key }) {
    const acts = {
      ArrowLeft: () => this.#turn(-STEP, 0),
      ArrowRight: () => this.#turn(STEP, 0),
      ArrowUp: () => this.#turn(0, STEP),
      ArrowDown: () => this.#turn(0, -STEP),
      "+": () => this.#zoom(1 / ZOOM),
      "-": () => this.#zoom(ZOOM),
    };
    acts[key]?.();
    return key in acts;
  }

  #turn(yaw, pitch) {
    this.#yaw += yaw;
    this.#pitch = Math.min(1.5, Math.max(-0.3, this.#pitch + pitch));
  }

  #zoom(factor) {
    this.#distance = Math.min(8, Math.max(0.8, this.#distance * factor));
  }

  /** A function from a point in the base's frame (m) to [x, y] on a canvas of this size, null behind the eye. */
  projection(width, height) {
    const [sy, cy, sp, cp] = [Math.sin(this.#yaw), Math.cos(this.#yaw), Math.sin(this.#pitch), Math.cos(this.#pitch)];
    const scale = 1.7 * Math.min(height, width);
    return ([x, y, z]) => {
      const [dx, dy, dz] = [x - this.#center[0], y - this.#center[1], z - this.#center[2]];
      const across = -sy * dx + cy * dy;
      const out = cy * dx + sy * dy;
      const depth = this.#distance - (cp * out + sp * dz);
      if (depth < 0.05) return null;
      return [width / 2 + (scale * across) / depth, height / 2 - (scale * (cp * dz - sp * out)) / depth];
    };
  }
}

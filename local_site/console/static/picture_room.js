// The room of the pictures: lays out the views and what stands beside them, and keeps the one that the operator has chosen large.
/** @import { Size } from "./arrangement.js" */
/** @import { Area } from "./mosaic.js" */
/** @import { View } from "./view.js" */
import { arranged, stacked, waiting } from "./arrangement.js";
import { element } from "./elements.js";
import { canPress, isPlain } from "./keys.js";
import { letter } from "./letters.js";

const KEY = "farhand-large";
const GAP_PX = 2;
const WIDE_STRIP = 2.2; // width by height, from which on its parts stand in a row
const LEAST_SHARE = 0.45; // of a page that scrolls, for the pictures
const SCROLLS = matchMedia("(max-width: 1000px)");

export class PictureRoom {
  #room = element("room");
  #cameras = element("cameras");
  #side = element("side");
  #strip = element("strip");
  #words = element("no-views");
  /** @type {View[] | null} */
  #views = null; // not known yet
  #large = localStorage.getItem(KEY);

  constructor() {
    addEventListener("keydown", (event) => this.#key(event));
    for (const sized of [this.#room, element("step")]) new ResizeObserver(() => this.arrange()).observe(sized);
    SCROLLS.addEventListener("change", () => this.arrange());
  }

  /** Show these views, in this order, and no others.
   * @type {(views: View[]) => void} */
  show(views) {
    const before = this.#views ?? [];
    for (const view of views.filter((one) => !before.includes(one))) {
      view.element.addEventListener("click", () => this.#choose(view));
      view.onShape = () => this.arrange();
    }
    const isSame = views.length === before.length && views.every((view, k) => view === before[k]);
    this.#views = views;
    if (!isSame) this.#cameras.replaceChildren(...views.map(({ element }) => element));
    this.arrange();
  }

  /** The view that is looked at most: the chosen one, or the first; undefined without any.
   * @returns {View | undefined} */
  get main() {
    return this.#views?.find(({ name }) => name === this.#large) ?? this.#views?.[0];
  }

  /** Lay everything out anew: the room, the letters, the views or their shapes have changed. */
  arrange() {
    const shown = this.#views ?? [];
    const large = shown.findIndex(({ name }) => name === this.#large);
    shown.forEach((view, k) => view.element.classList.toggle("enlarged", k === large));
    this.#room.toggleAttribute("data-waiting", this.#views === null);
    const [shapes, chosen] = [shown.map(({ aspect }) => aspect), large < 0 ? null : large];
    const boxes = SCROLLS.matches ? this.#stack(shapes, chosen) : this.#spread(shapes, chosen);
    shown.forEach((view, k) => place(view.element, boxes[k], GAP_PX));
  }

  /** @type {(shapes: number[], chosen: number | null) => Area[]} */
  #spread(shapes, chosen) {
    const room = { width: this.#room.clientWidth, height: this.#room.clientHeight };
    const { views, side, strip, words } = this.#views === null ? waiting(room, letter()) : arranged(shapes, chosen, room, letter());
    push(this.#side, side);
    place(this.#strip, strip);
    this.#strip.toggleAttribute("data-tall", strip !== null && strip.width < WIDE_STRIP * strip.height);
    place(this.#words, words ?? null);
    this.#cameras.style.height = "";
    return views;
  }

  /** @type {(shapes: number[], chosen: number | null) => Area[]} */
  #stack(shapes, chosen) {
    const { clientWidth: width, clientHeight: height } = this.#room;
    const most = Math.max(LEAST_SHARE * height, height - element("step").offsetHeight);
    const { views, height: high } = stacked(shapes, chosen, width, most);
    push(this.#side, null);
    for (const one of [this.#strip, this.#words]) place(one, null);
    this.#cameras.style.height = `${high}px`;
    return views;
  }

  /** @type {(event: KeyboardEvent) => void} */
  #key(event) {
    const view = this.#views?.[Number.parseInt(event.key, 10) - 1];
    if (view !== undefined && isPlain(event) && canPress(view.element)) this.#choose(view);
  }

  /** Make a view the large one, or all alike again.
   * @type {(view: View) => void} */
  #choose({ name }) {
    this.#large = this.#large === name ? null : name;
    if (this.#large === null) localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, this.#large);
    this.arrange();
  }
}

/** Put an element into a box of the room, or back into the page's flow where there is none.
 * @type {(one: HTMLElement, box: Area | null, gap?: number) => void} */
function place(one, box, gap = 0) {
  one.toggleAttribute("data-placed", box !== null);
  one.style.left = box === null ? "" : `${box.left}px`;
  one.style.top = box === null ? "" : `${box.top}px`;
  size(one, box, gap);
}

/** The same for the side, which stays in the flow: it is not to be what the strip inside it is placed by.
 * @type {(side: HTMLElement, box: Area | null) => void} */
function push(side, box) {
  side.style.margin = box === null ? "" : `${box.top}px 0 0 ${box.left}px`;
  size(side, box, 0);
}

/** @type {(one: HTMLElement, box: Size | null, gap: number) => void} */
function size(one, box, gap) {
  one.style.width = box === null ? "" : `${box.width - gap}px`;
  one.style.height = box === null ? "" : `${box.height - gap}px`;
}

// The operator's controls: who operates, engaging, scales, origins and locks, and the facts beside them.
/** @import { Answer, Axis, Cell, Hand, Hello, Robot, Seat, Settings, Situation } from "../model/messages.d.ts" */
/** @import { Alert } from "./alert.js" */
/** @import { Connection } from "./connection.js" */
/** @import { LeaseAct } from "./operators.js" */
import { element, tagged } from "./elements.js";
import { pressByKey } from "./keys.js";
import { leaseAct, leaseWords, seatWords } from "./operators.js";
import { ShownHalts } from "./shown_halts.js";
import { mark, put } from "./words.js";

/** @typedef {"engage" | "disengage" | "reset" | "origins"} Act */
/** @typedef {{ scale?: number, rotation_scale?: number, locks?: Partial<Record<Axis, boolean>> }} Changes */

/** @type {Record<string, Act>} */
const KEYS = { e: "engage", d: "disengage", r: "reset", n: "origins" };
const LEASE_KEY = "o"; // who operates
const OPERATED = ["hold", "clutch", "joints", "lease-button"]; // and those with keys
const SCALES = ["scale", "rotation"];
const MOVED_MS = 500; // after its last change
const READ_AGAIN_MS = 8000; // a refusal is read by then, and what it said may no longer be so

/** @type {(lock: HTMLElement) => Axis} */
const axisOf = (lock) => /** @type {Axis} */ (lock.dataset.lock);

export class Controls {
  #connection;
  #alert;
  #held = true;
  /** @type {string | null} */
  #refusedIn = null;
  /** @type {number | null} */
  #page = null;
  #operator = "";
  #mayOperate = false;
  #operates = false;
  /** @type {number | null} */
  #seatedPage = null;
  /** @type {string | null} */
  #settings = null;
  /** @type {number | null} */
  #lease = null;
  #known = false;
  #isBack = false;
  #steeredMs = -Infinity;
  /** @type {LeaseAct | null} */
  #leaseAct = null;
  #halts = new ShownHalts();
  /** @type {number | undefined} */
  #forgotten = undefined;
  #buttons = /** @type {Record<Act, HTMLButtonElement>} */ (Object.fromEntries(Object.values(KEYS).map((name) => [name, tagged("button", name)])));
  #locks = [.../** @type {NodeListOf<HTMLButtonElement>} */ (document.querySelectorAll("[data-lock]"))];

  /** @param {Connection} connection @param {Alert} alert */
  constructor(connection, alert) {
    this.#connection = connection;
    this.#alert = alert;
    for (const name of Object.values(KEYS)) this.#buttons[name].addEventListener("click", () => this.#act(name));
    for (const lock of this.#locks) lock.addEventListener("click", () => this.steer({ locks: { [axisOf(lock)]: lock.ariaPressed !== "true" } }));
    element("scale").addEventListener("input", () => this.steer({ scale: Number(tagged("input", "scale").value) }));
    element("rotation").addEventListener("input", () => this.steer({ rotation_scale: Number(tagged("input", "rotation").value) }));
    element("seat-button").addEventListener("click", () => this.#changeSeat());
    element("lease-button").addEventListener("click", () => this.#askLease());
    const pressed = Object.entries(KEYS).map(([key, name]) => [key, this.#buttons[name]]);
    pressByKey({ ...Object.fromEntries(pressed), [LEASE_KEY]: tagged("button", "lease-button") });
    this.#enable();
  }

  /** @type {(cell: Cell) => void} */
  describe({ held }) {
    this.#held = held;
  }

  /** @type {(message: Hello) => void} */
  hello({ page, operate, operator }) {
    this.#page = page;
    this.#operator = operator;
    this.#mayOperate = operate;
    this.#isBack = this.#settings !== null;
  }

  /** Show a reply that is shown nowhere else, until the next one or until the state changes.
   * @type {(answer: Answer) => void} */
  onReply({ what, done, reason }) {
    if (what === "stop") return;
    if (done) this.#alert.clear("controls");
    else {
      this.#complain(`${what}: ${reason}`);
      this.#forgotten = setTimeout(() => this.#alert.clear("controls"), READ_AGAIN_MS);
    }
  }

  /** Whether this page operates. */
  get operates() {
    return this.#operates;
  }

  /** Who operates, whose page this is, and what can be done about the lease. */
  get facts() {
    return { operates: this.#operates, mayOperate: this.#mayOperate, operator: this.#operator, act: this.#leaseAct };
  }

  /** Without a connection all controls are disabled. */
  disconnected() {
    this.#alert.clear("controls");
    this.#operates = false;
    this.#enable();
  }

  /** @type {(situation: Situation) => void} */
  show({ robot, hand, seat, settings }) {
    if (seat.page !== this.#seatedPage) this.#alert.clear("controls");
    this.#seatedPage = seat.page;
    this.#operates = seat.page === this.#page;
    this.#showSeat(seat, robot);
    this.#showSettings(settings);
    this.#showFacts(robot, hand);
    this.#enable();
    if (robot !== null) this.#halts.show(robot.halted_ns, performance.now());
    this.#refusedIn ??= robot?.state ?? null;
    if (robot !== null && robot.state !== this.#refusedIn) this.#alert.clear("controls");
  }

  #enable() {
    for (const button of [...Object.values(this.#buttons), ...OPERATED.map((id) => tagged("button", id))]) button.disabled = !this.#operates;
    const sets = this.#operates && this.#known;
    for (const control of [...this.#locks, ...SCALES.map((id) => tagged("input", id)), tagged("button", "suggestion"), this.#buttons.origins]) control.disabled = !sets;
  }

  /** @type {(seat: Seat, robot: Robot | null) => void} */
  #showSeat(seat, robot) {
    const words = seatWords(seat, robot, { operates: this.#operates, operator: this.#operator });
    put(element("seat"), words);
    mark(element("unheld"), "data-counts", this.#operates && words !== "");
    element("unheld").hidden = this.#held || Boolean(robot?.code.startsWith("clutch")); // the clutch's key is held
    put(element("seat-button"), this.#operates ? "Leave controls" : "Take controls");
    tagged("button", "seat-button").disabled = !this.#mayOperate;
  }

  /** @type {(words: string) => void} */
  #complain(words) {
    clearTimeout(this.#forgotten);
    this.#refusedIn = null;
    this.#alert.show("controls", "bad", words);
  }

  /** The settings in force at the remote site; null while they are unknown, and can then not be changed.
   * @type {(settings: Settings | null) => void} */
  #showSettings(settings) {
    this.#known = settings !== null;
    if (settings === null) return;
    const { lease, scale, rotation_scale, locks } = settings;
    const shown = JSON.stringify([scale, rotation_scale, locks]);
    const isOther = this.#isBack || lease !== this.#lease;
    if (isOther && this.#settings !== null && shown !== this.#settings) {
      this.#complain("scales or locks are no longer those that this page showed: check them before you engage");
    }
    this.#isBack = false;
    this.#lease = lease;
    this.#settings = shown;
    this.#put("scale", scale);
    this.#put("rotation", rotation_scale);
    for (const lock of this.#locks) mark(lock, "aria-pressed", locks[axisOf(lock)]);
  }

  /** A slider that is being moved is left alone; one that only has the focus shows what is in force, or the next key would jump.
   * @type {(id: string, value: number) => void} */
  #put(id, value) {
    const isMoved = document.activeElement === element(id) && performance.now() - this.#steeredMs < MOVED_MS;
    if (!isMoved) tagged("input", id).value = String(value);
    put(element(`${id}-value`), value.toFixed(2));
  }

  /** @type {(robot: Robot | null, hand: Hand | null) => void} */
  #showFacts(robot, hand) {
    put(element("hand"), hand === null || hand.silent ? "the local site is silent" : handWords(hand));
    put(element("gripper"), gripperWords(robot));
    put(element("lease"), leaseWords(robot));
    this.#leaseAct = leaseAct(robot?.lease ?? null, this.#operator);
    if (this.#leaseAct !== null) put(element("lease-words"), this.#leaseAct.words);
  }

  /** A reset names what its operator can have read, so that it clears no stop that came a moment ago.
   * @type {(name: Act) => void} */
  #act(name) {
    if (name === "origins") this.#connection.send({ type: "new_origins" });
    else this.#connection.ask({ type: "ask", action: name, seen: name === "reset" ? this.#halts.readBy(performance.now()) : this.#halts.newest });
  }

  /** Consent names who was shown to ask: it is void for anybody who asks by the time it arrives. */
  #askLease() {
    if (this.#leaseAct === null) return;
    const { action, to } = this.#leaseAct;
    this.#connection.ask({ type: "ask_lease", action, ...(to && { to }) });
  }

  /** Ask for other scales or locks.
   * @type {(changes: Changes) => void} */
  steer(changes) {
    this.#steeredMs = performance.now();
    this.#connection.send({ type: "steer", ...changes });
  }

  #changeSeat() {
    element("seat-button").blur(); // the same button gives the controls back: no key may press it unseen
    this.#connection.ask({ type: this.#operates ? "leave_seat" : "take_seat" });
  }
}

/** @type {(hand: Hand) => string} */
function handWords({ status, reason, open }) {
  const words = [status, open ? "open" : "closed"];
  return reason ? `${words.join(", ")}: ${reason}` : words.join(", ");
}

/** @type {(robot: Robot | null) => string} */
function gripperWords(robot) {
  if (robot === null) return "unknown";
  const { gripper, gripper_next } = robot;
  const next = `a toggle ${gripper_next === "open" ? "opens" : "closes"} it`;
  if (gripper === null) return `not measured; ${next}`;
  const force = gripper.force === null ? "" : `, ${gripper.force.toFixed(0)} N`;
  return `${gripper.status.replace("_", " ")}, ${(gripper.opening * 1000).toFixed(0)} mm${force}; ${next}`;
}

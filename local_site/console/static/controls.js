// The operator's controls: who operates, engaging, scales, origins and locks, and the facts beside them.
import { pressByKey } from "./keys.js";
import { leaseAct, leaseWords, seatWords } from "./operators.js";
import { ShownHalts } from "./shown_halts.js";
import { mark, put } from "./words.js";

const KEYS = { e: "engage", d: "disengage", r: "reset", n: "origins" };
const LEASE_KEY = "o"; // who operates
const MOVED_MS = 500; // after its last change
const READ_AGAIN_MS = 8000; // a refusal is read by then, and what it said may no longer be so
const element = (id) => document.getElementById(id);

export class Controls {
  #connection;
  #alert;
  #held = true;
  #refusedIn = null;
  #page = null;
  #operator = "";
  #mayOperate = false;
  #operates = false;
  #seatedPage = null;
  #settings = null;
  #lease = null;
  #known = false;
  #isBack = false;
  #steeredMs = -Infinity;
  #leaseAct = null;
  #halts = new ShownHalts();
  #forgotten = null;
  #buttons = Object.fromEntries(Object.values(KEYS).map((name) => [name, element(name)]));
  #locks = [...document.querySelectorAll("[data-lock]")];

  constructor(connection, alert) {
    this.#connection = connection;
    this.#alert = alert;
    for (const [name, button] of Object.entries(this.#buttons)) button.addEventListener("click", () => this.#act(name));
    for (const lock of this.#locks) lock.addEventListener("click", () => this.steer({ locks: { [lock.dataset.lock]: lock.ariaPressed !== "true" } }));
    element("scale").addEventListener("input", () => this.steer({ scale: Number(element("scale").value) }));
    element("rotation").addEventListener("input", () => this.steer({ rotation_scale: Number(element("rotation").value) }));
    element("seat-button").addEventListener("click", () => this.#changeSeat());
    element("lease-button").addEventListener("click", () => this.#askLease());
    const pressed = Object.entries(KEYS).map(([key, name]) => [key, this.#buttons[name]]);
    pressByKey({ ...Object.fromEntries(pressed), [LEASE_KEY]: element("lease-button") });
    this.#enable();
  }

  describe({ held }) {
    this.#held = held;
  }

  hello({ page, operate, operator }) {
    this.#page = page;
    this.#operator = operator;
    this.#mayOperate = operate;
    this.#isBack = this.#settings !== null;
  }

  /** Show a reply that is shown nowhere else, until the next one or until the state changes. */
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
    for (const button of [...Object.values(this.#buttons), element("hold"), element("clutch"), element("joints"), element("lease-button")]) button.disabled = !this.#operates;
    const sets = this.#operates && this.#known;
    for (const control of [...this.#locks, element("scale"), element("rotation"), element("suggestion"), this.#buttons.origins]) control.disabled = !sets;
  }

  #showSeat(seat, robot) {
    const words = seatWords(seat, robot, { operates: this.#operates, operator: this.#operator });
    put(element("seat"), words);
    mark(element("unheld"), "data-counts", this.#operates && words !== "");
    element("unheld").hidden = this.#held || Boolean(robot?.code.startsWith("clutch")); // the clutch's key is held
    put(element("seat-button"), this.#operates ? "Leave controls" : "Take controls");
    element("seat-button").disabled = !this.#mayOperate;
  }

  #complain(words) {
    clearTimeout(this.#forgotten);
    this.#refusedIn = null;
    this.#alert.show("controls", "bad", words);
  }

  /** The settings in force at the remote site; null while they are unknown, and can then not be changed. */
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
    for (const lock of this.#locks) mark(lock, "aria-pressed", locks[lock.dataset.lock]);
  }

  /** A slider that is being moved is left alone; one that only has the focus shows what is in force, or the next key would jump. */
  #put(id, value) {
    const isMoved = document.activeElement === element(id) && performance.now() - this.#steeredMs < MOVED_MS;
    if (!isMoved) element(id).value = value;
    put(element(`${id}-value`), value.toFixed(2));
  }

  #showFacts(robot, hand) {
    put(element("hand"), hand === null || hand.silent ? "the local site is silent" : handWords(hand));
    put(element("gripper"), gripperWords(robot));
    put(element("lease"), leaseWords(robot));
    this.#leaseAct = leaseAct(robot?.lease ?? null, this.#operator);
    if (this.#leaseAct !== null) put(element("lease-words"), this.#leaseAct.words);
  }

  /** A reset names what its operator can have read, so that it clears no stop that came a moment ago. */
  #act(name) {
    if (name === "origins") this.#connection.send({ type: "new_origins" });
    else this.#connection.ask({ type: "ask", action: name, seen: name === "reset" ? this.#halts.readBy(performance.now()) : this.#halts.newest });
  }

  /** Consent names who was shown to ask: it is void for anybody who asks by the time it arrives. */
  #askLease() {
    const { action, to } = this.#leaseAct;
    this.#connection.ask({ type: "ask_lease", action, ...(to && { to }) });
  }

  /** Ask for other scales or locks. */
  steer(changes) {
    this.#steeredMs = performance.now();
    this.#connection.send({ type: "steer", ...changes });
  }

  #changeSeat() {
    element("seat-button").blur(); // the same button gives the controls back: no key may press it unseen
    this.#connection.ask({ type: this.#operates ? "leave_seat" : "take_seat" });
  }
}

function handWords({ status, reason, open }) {
  const words = [status, open ? "open" : "closed"];
  return reason ? `${words.join(", ")}: ${reason}` : words.join(", ");
}

function gripperWords(robot) {
  if (robot === null) return "unknown";
  const { gripper, gripper_next } = robot;
  const next = `a toggle ${gripper_next === "open" ? "opens" : "closes"} it`;
  if (gripper === null) return `not measured; ${next}`;
  const force = gripper.force === null ? "" : `, ${gripper.force.toFixed(0)} N`;
  return `${gripper.status.replace("_", " ")}, ${(gripper.opening * 1000).toFixed(0)} mm${force}; ${next}`;
}

// Who operates: in words, and what can be done about it; pure.
/** @import { Lease, Robot, Seat } from "../model/messages.d.ts" */
import { holderWords, isAnothers } from "./condition.js";

/** @typedef {{ action: "take" | "give", words: string, isAsked?: boolean, to?: { name: string, session: string } }} LeaseAct */

const LATE = ", but page and console hear each other too late: what you hold does not count";

/**
 * Who operates, for the line below the buttons. It is empty on the page that has the controls of this console, but no robot to move by
 * them, or none that answers: the bar says who has it, and the next step what to do.
 * @type {(seat: Seat, robot: Robot | null, facts: { operates: boolean, operator: string }) => string}
 */
export function seatWords(seat, robot, { operates, operator }) {
  const isOurs = robot === null || (robot.lease !== null && !isAnothers(robot.lease, operator));
  if (operates) return isOurs && !robot?.silent ? `you operate (page ${seat.page})${seat.late ? LATE : ""}` : "";
  return `you watch; ${seat.who ?? "nobody"} ${isOurs ? "operates" : "has the controls here"}`;
}

/** What this operator can do about the lease: take it, ask its holder for it, or hand it to the operator who asks; or nothing.
 * @type {(lease: Lease | null, operator: string) => LeaseAct | null} */
export function leaseAct(lease, operator) {
  if (lease === null) return { action: "take", words: "Take the robot" };
  const asker = lease.asked_by;
  if (lease.ours) {
    if (asker === null) return null;
    const { name, session, words } = asker;
    return { action: "give", to: { name, session }, words: `Hand over to ${holderWords({ holder: name, words }, operator)}` };
  }
  const isAsked = asker?.name === operator;
  return { action: "take", isAsked, words: isAsked ? "Ask again" : `Ask ${holderWords(lease, operator)} for it` };
}

/** Who holds the lease, and who asks for it.
 * @type {(robot: Robot | null) => string} */
export function leaseWords(robot) {
  if (robot === null) return "unknown";
  return robot.lease === null ? "nobody holds it" : `${robot.lease.words}${robot.lease.asked_by ? `, asked by ${robot.lease.asked_by.words}` : ""}`;
}

// Who has stopped the arm, and what has failed, as this page's operator says it, from the remote site's sentence; pure.
/** @import { Visitor } from "../model/messages.d.ts" */

/** @typedef {{ page: number | null, operator: string, remote: string }} Whose */
/** @typedef {{ who: string, cause: string }} Halt */

const TAIL = "; reset it, then engage"; // the next step says it, with who may and by which button
const EXIT_CODE = / \(exit code -?\d+\)/; // for whoever reads the log; to an operator it says nothing
const CODE = /^[a-z_]+(?: \([^)]*\))?: /; // of the fault, with the robot's own: for the log, too
const STOPPED_BY = /^stopped by (.+?)(?:; (.*))?$/s;

/**
 * What halted the arm: `who` stopped it, empty where nobody did, and the `cause` of a fault, empty without one. `stopper` is the page
 * of this console that asked for the stop that stands, `operator` the name under which all pages of this console stop the arm.
 * @type {(reason: string, whose: Whose, stopper: Visitor | null) => Halt}
 */
export function haltOf(reason, { page, operator }, stopper) {
  const said = (reason.endsWith(TAIL) ? reason.slice(0, -TAIL.length) : reason).replace(EXIT_CODE, "");
  const found = STOPPED_BY.exec(said);
  if (found === null) return { who: "", cause: said.replace(CODE, "") };
  /** @type {(name: string) => string} */
  const named = (name) => (name === operator ? here(name, page, stopper) : name);
  const who = found[1].split(/(, | and )/).map(named).join("");
  return { who, cause: (found[2] ?? "").replace(CODE, "") };
}

/** @type {(name: string, page: number | null, stopper: Visitor | null) => string} */
function here(name, page, stopper) {
  if (stopper === null || stopper.page === null) return name; // as by 'farhand stop'
  return stopper.page === page ? "you" : `another page, ${stopper.who}`;
}

/** The halt as one sentence.
 * @type {(halt: Halt) => string} */
export const haltSentence = ({ who, cause }) => [who && `stopped by ${who}`, cause].filter(Boolean).join(" · ");

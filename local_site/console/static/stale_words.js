// What the next step says first of the cell's pictures, where they do not show what the arm does now; pure.
/** @typedef {{ name: string, mark: string, isUseful: boolean, ageMs: number | null }} Standing */

const MOST_NAMED = 2; // more would push the step itself out of sight
const SHOWS = ["live", "slow"];

/**
 * Which views are not live and how old their pictures are, empty while all are. A view has its `name`, `mark`, whether it `isUseful`, and
 * the `ageMs` of its newest picture, null where that is not known.
 * @type {(views: Standing[]) => string}
 */
export function staleWords(views) {
  const stale = views.filter(({ mark, isUseful }) => !SHOWS.includes(mark) || !isUseful);
  if (stale.length === 0) return "";
  if (!views.some(({ isUseful }) => isUseful)) return `No live picture of the cell.${newestWords(views)}`;
  if (stale.length === views.length && stale.every(isLate)) return "All pictures of the cell come late.";
  const named = stale.slice(0, MOST_NAMED).map((view) => `${view.name} ${troubleOf(view)}`);
  const more = stale.length - named.length;
  return `Look out: ${[...named, ...(more > 0 ? [`${more} more`] : [])].join(", ")}.`;
}

/** @type {(view: Pick<Standing, "mark" | "ageMs">) => boolean} */
const isLate = ({ mark, ageMs }) => mark === "old" && ageMs !== null && ageMs < 1000;

/** @type {(views: Standing[]) => string} */
function newestWords(views) {
  const ages = views.map(({ ageMs }) => ageMs).filter((ageMs) => ageMs !== null);
  return ages.length === 0 ? "" : ` The newest is ${oldWords(Math.min(...ages))}.`;
}

/** As "is 3 s old", "is frozen, 3 s old", "comes late" or "has no picture".
 * @type {(view: Standing) => string} */
function troubleOf({ mark, ageMs }) {
  if (mark === "none") return "has no picture";
  if (isLate({ mark, ageMs })) return "comes late";
  const age = ageMs === null ? "of unknown age" : oldWords(ageMs);
  return mark === "old" || mark === "slow" ? `is ${age}` : `is ${mark}, ${age}`;
}

/** Whole seconds, so that the words stand long enough to be read.
 * @type {(ms: number) => string} */
function oldWords(ms) {
  const seconds = Math.round(ms / 1000);
  return seconds < 1 ? "less than 1 s old" : seconds < 60 ? `${seconds} s old` : `${Math.floor(seconds / 60)} min old`;
}

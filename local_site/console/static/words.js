// Sets texts and attributes only when they change, so that unchanged ones cost no redrawing.

export const READ_MS = 250; // figures that change faster are not read, and each change has the page laid out anew

/** @type {(element: Node, words: string) => void} */
export function put(element, words) {
  if (element.textContent !== words) element.textContent = words;
}

/** @type {(element: Element, name: string, value: string | number | boolean) => void} */
export function mark(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, String(value));
}

/** Hours, where there are any, minutes and seconds, as on a clock.
 * @type {(seconds: number) => string} */
export function clockWords(seconds) {
  const [hours, minutes, rest] = [Math.floor(seconds / 3600), Math.floor(seconds / 60) % 60, Math.floor(seconds % 60)];
  /** @type {(value: number) => string} */
  const two = (value) => String(value).padStart(2, "0");
  return hours > 0 ? `${hours}:${two(minutes)}:${two(rest)}` : `${minutes}:${two(rest)}`;
}

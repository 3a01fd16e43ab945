// Sets texts and attributes only when they change, so that unchanged ones cost no redrawing.

export const READ_MS = 250; // figures that change faster are not read, and each change has the page laid out anew

export function put(element, words) {
  if (element.textContent !== words) element.textContent = words;
}

export function mark(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

// Sets texts and attributes only when they change, so that unchanged ones cost no redrawing.

export function put(element, words) {
  if (element.textContent !== words) element.textContent = words;
}

export function mark(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

// Words on the page, put there only when they change: what stays the same costs no drawing.

export function put(element, words) {
  if (element.textContent !== words) element.textContent = words;
}

export function mark(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

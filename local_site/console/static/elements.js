// The elements of the page's document by their ids, which `index.html` gives them.

/** @type {(id: string) => HTMLElement} */
export const element = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

/**
 * The same where a kind of element is needed.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {string} id
 */
export function tagged(tag, id) {
  return /** @type {HTMLElementTagNameMap[K]} */ (document.querySelector(`${tag}#${id}`));
}

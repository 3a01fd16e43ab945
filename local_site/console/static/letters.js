// How large the page's letters are now: they grow with the screen, and what is drawn on canvases follows them.
let px = read();

function read() {
  return parseFloat(getComputedStyle(document.documentElement).fontSize);
}

/** Read the size again: the window or the type has changed. */
export function measureLetters() {
  px = read();
}

/** The height of a letter of ordinary text, in CSS pixels. */
export const letter = () => px;

addEventListener("resize", measureLetters);

/** How much larger everything is than on a small screen, where a letter has 14 pixels. */
export const growth = () => px / 14;

// What a check of the layout asks of a page: words beyond its sides, words cut off by what they are in, and words over words.
() => {
  const shown = (element) => element.checkVisibility() && element.closest(".unseen, :disabled") === null;
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const words = [];
  while (texts.nextNode()) {
    const [node, element] = [texts.currentNode, texts.currentNode.parentElement];
    if (!node.data.trim() || !(element.checkVisibility()) || element.closest(".unseen, option, select")) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const box of range.getClientRects()) words.push({ element, text: node.data.trim().slice(0, 40), box });
  }
  const controls = [...document.querySelectorAll("button, input, select")].filter(shown);
  const boxes = [...words, ...controls.map((element) => ({ element, text: element.id || element.ariaLabel, box: element.getBoundingClientRect() }))];
  const width = document.documentElement.clientWidth;
  const clamped = (element) => getComputedStyle(element).webkitLineClamp !== "none";

  /** What cuts these words off: an element around them that shows nothing beyond its sides, nor scrolls there. */
  const isCut = ({ element, box }) => {
    for (let around = element; around !== document.body && around !== null; around = around.parentElement) {
      const { overflowX, overflowY } = getComputedStyle(around);
      const edge = around.getBoundingClientRect();
      if (overflowX !== "visible" && (box.left < edge.left - 1 || box.right > edge.right + 1)) return true;
      if (overflowY === "hidden" && !clamped(around) && (box.top < edge.top - 1 || box.bottom > edge.bottom + 1)) return true;
      if (overflowY === "auto") return false;
    }
    return false;
  };

  const meet = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1 && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 2;
  const isAlarm = (element) => element.closest("[role=alert]") !== null; // lies over the rest, so that it moves nothing
  const apart = (a, b) => !isAlarm(a) && !isAlarm(b) && !a.contains(b) && !b.contains(a) && a.closest(".view") === b.closest(".view") && !clamped(a) && !clamped(b);
  const overlapping = [];
  words.forEach((one, k) => {
    for (const other of words.slice(k + 1)) {
      if (apart(one.element, other.element) && meet(one.box, other.box)) overlapping.push(`${one.text} | ${other.text}`);
    }
  });
  return {
    width: document.documentElement.scrollWidth,
    outside: boxes.filter(({ box }) => box.left < 0 || box.right > width).map(({ text }) => text),
    cut: words.filter(isCut).map(({ text }) => text),
    thin: controls.filter((element) => element.getBoundingClientRect().width < 24).map((element) => element.id),
    overlapping,
  };
}

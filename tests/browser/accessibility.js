// What an accessibility check asks of a page: the contrast of every text, and elements without a name.
() => {
  const parse = (colour) => {
    const parts = colour.match(/[\d.]+/g).map(Number);
    return { rgb: parts.slice(0, 3), alpha: parts[3] ?? 1 };
  };
  const over = (top, under) => top.rgb.map((v, k) => v * top.alpha + under[k] * (1 - top.alpha));
  const luminance = (rgb) => {
    const [r, g, b] = rgb.map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (a, b) => {
    const [light, dark] = [luminance(a), luminance(b)].sort((x, y) => y - x);
    return (light + 0.05) / (dark + 0.05);
  };
  // Below words on a picture anything may be seen: white is the worst for light words.
  const background = (element) => {
    if (element === null) return [255, 255, 255];
    if (element.classList.contains("view")) return [255, 255, 255];
    const own = parse(getComputedStyle(element).backgroundColor);
    return own.alpha === 1 ? own.rgb : over(own, background(element.parentElement));
  };
  const poor = [];
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const element = texts.currentNode.parentElement;
    const words = texts.currentNode.data.trim();
    if (!words || !element.checkVisibility() || element.closest(".unseen, :disabled")) continue;
    const style = getComputedStyle(element);
    const size = parseFloat(style.fontSize);
    const least = size >= 24 || (size >= 18.66 && style.fontWeight >= 700) ? 3 : 4.5;
    const found = contrast(parse(style.color).rgb, background(element));
    if (found < least) poor.push(`${words}: ${found.toFixed(2)}`);
  }
  const label = (element) =>
    element.getAttribute("aria-label") ??
    (element.getAttribute("aria-labelledby") ? document.getElementById(element.getAttribute("aria-labelledby")).textContent : null) ??
    element.labels?.[0]?.textContent ?? element.textContent;
  const wanted = [...document.querySelectorAll("button, input, [tabindex], section, [role=img]")];
  return {
    poor,
    nameless: wanted.filter((element) => !label(element)?.trim()).map((element) => element.outerHTML.slice(0, 80)),
    small: wanted.filter((e) => e.tagName === "BUTTON" && e.checkVisibility() && Math.min(e.clientWidth, e.clientHeight) < 24).map(label),
    wide: document.documentElement.scrollWidth > innerWidth,
    language: document.documentElement.lang,
    headings: document.querySelectorAll("h1").length,
  };
}

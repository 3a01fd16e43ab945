// What every drawing needs: a canvas as sharp as the screen, and the page's colours.

/** The canvas's size in CSS pixels, with its pixels brought to the screen's. */
export function sized(canvas, brush) {
  const { clientWidth: width, clientHeight: height } = canvas;
  const ratio = devicePixelRatio;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  brush.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { width, height };
}

/** The page's colours by name, as they are now. */
export function tones(...names) {
  const style = getComputedStyle(document.documentElement);
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

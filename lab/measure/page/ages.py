"""Ages of the pictures that a page paints, and what the browser's processes take for each."""

import time
from dataclasses import dataclass

import numpy as np

from lab.measure.page.chromium import Chromium, Tab
from lab.measure.page.painted_clock import ages_ms, compare, watch

SETTLE_S = 6.0
PICTURES = "window.paintedPictures"
Figures = dict[str, float]


@dataclass(frozen=True, slots=True)
class Painting:
    """Ages (ms) of each cell view's painted pictures, all pictures with the operator's, and processor time, s."""

    ages: dict[str, list[float]]
    pictures: int
    cpu_s: float
    seconds: float

    def figures(self, name: str) -> Figures:
        """Percentiles over all views, pictures a second of a view, and processor time for a picture."""
        together = np.concatenate([*self.ages.values(), []])
        return {
            f"{name}_p50_ms": float(np.percentile(together, 50)),
            f"{name}_p95_ms": float(np.percentile(together, 95)),
            f"{name}_fps": len(together) / self.seconds / max(1, len(self.ages)),
            f"{name}_browser_cpu_ms_per_picture": 1000 * self.cpu_s / max(1, self.pictures),
        }


def painting(chromium: Chromium, page: Tab, seconds: float) -> Painting:
    """Measure what the page paints over `seconds` once it has settled."""
    clock = compare(page)
    watch(page)
    time.sleep(SETTLE_S)
    ages_ms(page, clock)  # discards what was painted meanwhile
    pictures, cpu_s, began_s = page.evaluate(PICTURES), chromium.cpu_s, time.monotonic()
    time.sleep(seconds)
    ages = ages_ms(page, clock)
    painted = page.evaluate(PICTURES) - pictures
    return Painting(ages, painted, chromium.cpu_s - cpu_s, time.monotonic() - began_s)

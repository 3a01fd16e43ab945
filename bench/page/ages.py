"""How old the pictures are that a page paints, and what the browser's processes take for each."""

import time
from dataclasses import dataclass

import numpy as np

from bench.page.chromium import Chromium, Tab
from bench.page.painted_clock import ages_ms, compare, watch

SETTLE_S = 6.0
Figures = dict[str, float]


@dataclass(frozen=True, slots=True)
class Painting:
    """Ages (ms) of each view's painted pictures, and the browser's processor time meanwhile, s."""

    ages: dict[str, list[float]]
    cpu_s: float
    seconds: float

    def figures(self, name: str) -> Figures:
        """Percentiles over all views, pictures a second of a view, and processor time for a picture."""
        together = np.concatenate([*self.ages.values(), []])
        return {
            f"{name}_p50_ms": float(np.percentile(together, 50)),
            f"{name}_p95_ms": float(np.percentile(together, 95)),
            f"{name}_fps": len(together) / self.seconds / max(1, len(self.ages)),
            f"{name}_browser_cpu_ms_per_picture": 1000 * self.cpu_s / max(1, len(together)),
        }


def painting(chromium: Chromium, page: Tab, seconds: float) -> Painting:
    """What the page paints over `seconds` once it has settled."""
    clock = compare(page)
    watch(page)
    time.sleep(SETTLE_S)
    ages_ms(page, clock)  # discards what was painted meanwhile
    cpu_s, began_s = chromium.cpu_s, time.monotonic()
    time.sleep(seconds)
    ages = ages_ms(page, clock)
    return Painting(ages, chromium.cpu_s - cpu_s, time.monotonic() - began_s)

"""Exposure times of the pictures that the browser paints, read from the clock drawn into each."""

import time
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from common.clock import NS_PER_MS
from lab.measure.page.chromium import Tab
from lab.stage.clock_strip import WRAP_MS, read_clock

WATCH = (Path(__file__).parent / "painted_clock.js").read_text(encoding="utf-8").partition("\n")[2]
TRIPS = 40
CELL_PIXELS = 6
ROWS = 20


@dataclass(frozen=True, slots=True)
class PageClock:
    """The page's `performance.now()` against this process's monotonic clock, with its uncertainty, ms."""

    offset_ms: float
    uncertainty_ms: float


def compare(page: Tab) -> PageClock:
    """Ask a page for its time; of many answers the quickest counts."""
    best = PageClock(0.0, float("inf"))
    for _ in range(TRIPS):
        before_ms = time.monotonic_ns() / NS_PER_MS
        page_ms = float(page.evaluate("performance.now()"))
        after_ms = time.monotonic_ns() / NS_PER_MS
        if (after_ms - before_ms) / 2 < best.uncertainty_ms:
            best = PageClock((before_ms + after_ms) / 2 - page_ms, (after_ms - before_ms) / 2)
    return best


def watch(page: Tab) -> None:
    """Start to record what each view shows at every frame of the browser."""
    page.evaluate(f"({WATCH.strip().rstrip(';')})()")


def ages_ms(page: Tab, clock: PageClock) -> dict[str, list[float]]:
    """Recorded since the last call: the ages of the pictures of each view when they were first seen, ms."""
    found = defaultdict(list)
    for view, page_ms, cells in page.evaluate("window.paintedClocks.splice(0)"):
        exposed_ms = _read(cells)
        if exposed_ms is not None:
            found[view].append((page_ms + clock.offset_ms - exposed_ms) % WRAP_MS)
    return dict(found)


def _read(cells: str) -> int | None:
    """The milliseconds in the cells of a strip; None where they cannot be read."""
    levels = np.array([{"1": 255, "0": 0, "?": 127}[cell] for cell in cells], dtype=np.uint8)
    return read_clock(np.tile(np.repeat(levels, CELL_PIXELS), (ROWS, 1)))

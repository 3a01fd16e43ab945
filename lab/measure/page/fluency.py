"""Ten minutes of the page beside both sites: its slowest and latest ten seconds; and what it takes without pictures."""

import math
import time
from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from lab.measure.page.ages import SETTLE_S, Figures
from lab.measure.page.chromium import Chromium
from lab.measure.page.painted_clock import ages_ms, compare, watch
from lab.measure.page.stand import AS_LOOPBACK, PageStand
from remote_site.config import RemoteConfig

MINUTES, WINDOW_S = 10, 10.0
LEAST_FPS, MOST_MS = 20.0, 80.0  # asked of each view
HARDLY_ANY = "video.fps=1"
HARDLY_ANY_OWN = "preview.fps=1"
QUIET_S = 30.0

Window = dict[str, list[float]]  # of each view, the ages (ms) of the pictures that were painted


def measure() -> Figures:
    """The figures by name; CameraError where EGL is missing, ProcessError where Chromium is."""
    views = [camera.name for camera in RemoteConfig().video.cameras]
    figures = judged(_windows(), views, WINDOW_S) | {"browser_core_percent_at_1_fps": _without_pictures()}
    return {name: round(value, 3) for name, value in figures.items()}


def judged(windows: Sequence[Window], views: Sequence[str], seconds: float) -> Figures:
    """Of windows of some seconds: the slowest view's rate, the age of 95 % of all views, how many miss what is asked.

    A window in which a view has painted nothing misses both.
    """
    rates = [min(len(window.get(view, ())) / seconds for view in views) for window in windows]
    painted = [np.concatenate([*window.values(), []]) for window in windows]
    ages = [float(np.percentile(every, 95)) if len(every) else math.inf for every in painted]
    return {
        "windows": float(len(windows)),
        "fps_p50": float(np.median(rates)),
        "fps_worst": min(rates),
        "p95_ms_p50": float(np.median(ages)),
        "p95_ms_worst": max(ages),
        f"windows_below_{LEAST_FPS:.0f}_fps": float(sum(rate < LEAST_FPS for rate in rates)),
        f"windows_above_{MOST_MS:.0f}_ms": float(
            sum(age > MOST_MS or rate == 0.0 for age, rate in zip(ages, rates, strict=True))
        ),
    }


def _windows() -> list[Window]:
    with Chromium() as chromium, ExitStack() as stack:
        stand = PageStand(stack, *AS_LOOPBACK)
        stand.follow()
        page = chromium.open(stand.console(stand.video_port)[1])
        watch(page)
        time.sleep(SETTLE_S)
        windows = []
        for _ in range(round(60 * MINUTES / WINDOW_S)):
            clock = compare(page)
            ages_ms(page, clock)  # discards what was painted meanwhile
            time.sleep(WINDOW_S)
            windows.append(ages_ms(page, clock))
        return windows


def _without_pictures() -> float:
    """Core percent of the browser while the arm follows and hardly a picture comes: the page's own drawing."""
    with Chromium() as chromium, ExitStack() as stack:
        stand = PageStand(stack, *AS_LOOPBACK, HARDLY_ANY)
        stand.follow(HARDLY_ANY_OWN)
        chromium.open(stand.console(stand.video_port)[1])
        time.sleep(SETTLE_S)
        before_s = chromium.cpu_s
        time.sleep(QUIET_S)
        return 100.0 * (chromium.cpu_s - before_s) / QUIET_S

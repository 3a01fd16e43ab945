"""Benchmark of the operator's page: from glass to glass, narrow links, from the stop key to rest, and its load."""

import time
from contextlib import ExitStack

import numpy as np

from common.clock import NS_PER_S
from farhand.loopback.site_process import free_ports
from lab.measure.page.ages import Figures
from lab.measure.page.bare_page import bare_figures
from lab.measure.page.chromium import Chromium, Tab
from lab.measure.page.narrow_link import NarrowLink
from lab.measure.page.painted_clock import PageClock, ages_ms, compare, watch
from lab.measure.page.stand import PageStand
from lab.measure.page.whole_page import split_figures, whole_figures

COMPARED = ("p50_ms", "p95_ms", "browser_cpu_ms_per_picture")
MEASURE_S = 15.0
LINK_SETTLE_S = 10.0
NARROW_MBIT_S = (20.0, 5.0)
OPEN_MBIT_S = 1e4  # not limited


def narrow_figures() -> Figures:
    """The page's figures over links of too little bandwidth, with pictures at full quality."""
    figures: Figures = {}
    with Chromium() as chromium, ExitStack() as stack:
        stand, port = PageStand(stack, "video.quality=100"), free_ports(1)[0]
        stand.follow()
        link = stack.enter_context(NarrowLink(port, stand.video_port, OPEN_MBIT_S))
        _, address = stand.console(port)
        page = chromium.open(address)
        clock = compare(page)
        watch(page)
        for mbit_s in (OPEN_MBIT_S, *NARROW_MBIT_S):
            link.mbit_s = mbit_s
            time.sleep(LINK_SETTLE_S)
            figures |= link_figures(page, clock, link, "open" if mbit_s == OPEN_MBIT_S else f"{mbit_s:g}_mbit_s")
    return figures


def link_figures(page: Tab, clock: PageClock, link: NarrowLink, name: str) -> Figures:
    """Ages, the frame rates of the slowest and the fastest view, and the bandwidth used."""
    ages_ms(page, clock)  # discards what was painted before
    before_bytes, began_ns = link.carried_bytes, time.monotonic_ns()
    time.sleep(MEASURE_S)
    ages, passed_s = ages_ms(page, clock), (time.monotonic_ns() - began_ns) / NS_PER_S
    together = np.concatenate([*ages.values(), []])
    rates = [len(values) / passed_s for values in ages.values()]
    return {
        f"link_{name}_used_mbit_s": 8e-6 * (link.carried_bytes - before_bytes) / passed_s,
        f"link_{name}_p50_ms": float(np.percentile(together, 50)),
        f"link_{name}_p95_ms": float(np.percentile(together, 95)),
        f"link_{name}_fps_min": min(rates),
        f"link_{name}_fps_max": max(rates),
    }


def measure() -> Figures:
    """The figures by name; CameraError where EGL is missing, ProcessError where Chromium is."""
    bare, whole = bare_figures(), whole_figures()
    ratios = {
        f"glass_to_glass_{name}_ratio_to_bare": whole[f"glass_to_glass_{name}"] / bare[f"bare_{name}"]
        for name in COMPARED
    }
    return {
        name: round(value, 3) for name, value in (bare | whole | ratios | split_figures() | narrow_figures()).items()
    }

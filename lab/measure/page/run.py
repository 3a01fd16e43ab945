"""Benchmark of the operator's page: from glass to glass, narrow links, from the stop key to rest, and its load."""

from lab.measure.page.ages import Figures
from lab.measure.page.bare_page import bare_figures
from lab.measure.page.links import narrow_figures
from lab.measure.page.whole_page import split_figures, whole_figures

COMPARED = ("p50_ms", "p95_ms", "browser_cpu_ms_per_picture")


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

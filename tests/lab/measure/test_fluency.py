"""Ten minutes of the page are judged by their worst ten seconds, and a view that stands still is not left out."""

import pytest

from lab.measure.page.fluency import judged

VIEWS = ("front", "side")


def window(front: int, side: int, age_ms: float) -> dict[str, list[float]]:
    return {view: [age_ms] * count for view, count in (("front", front), ("side", side)) if count}


def test_the_slowest_view_and_the_latest_pictures_count() -> None:
    figures = judged([window(300, 250, 40.0), window(200, 199, 81.0), window(300, 300, 80.0)], VIEWS, 10.0)
    assert figures["fps_worst"] == pytest.approx(19.9)
    assert figures["fps_p50"] == pytest.approx(25.0)
    assert figures["p95_ms_worst"] == pytest.approx(81.0)
    assert (figures["windows_below_20_fps"], figures["windows_above_80_ms"]) == (1.0, 1.0)


def test_a_view_that_stands_still_misses_both() -> None:
    figures = judged([window(300, 0, 40.0), {}], VIEWS, 10.0)
    assert (figures["fps_worst"], figures["windows_below_20_fps"], figures["windows_above_80_ms"]) == (0.0, 2.0, 2.0)

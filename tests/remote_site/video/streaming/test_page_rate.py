"""The rate for the operator's page: what it cannot paint is not sent, and no fewer than are of use to who looks."""

from collections.abc import Callable

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.video import ViewCame, ViewShown
from remote_site.video.streaming.page_rate import LEAST_FPS, PageRate

REPORT_NS = 100 * NS_PER_MS
FULL_FPS = 30.0


def rates(paints: Callable[[float], float], lag_ms: float, seconds: float, page: PageRate | None = None) -> list[float]:
    """The rate after each report of a page that paints so many of what comes, so late."""
    page, found = page or PageRate(), list[float]()
    for k in range(round(seconds * NS_PER_S / REPORT_NS)):
        came = round(page.fps or FULL_FPS)
        view = ViewShown(
            seq=k,
            capture_ns=0,
            age_ms=20.0 + lag_ms,
            fps=max(0.0, paints(came)),
            came=ViewCame(seq=k, age_ms=20.0, fps=came),
        )
        page.report([view] * 4, FULL_FPS, (k + 1) * REPORT_NS)
        found.append(page.fps or FULL_FPS)
    return found


@pytest.mark.parametrize(("lag_ms", "least", "most"), [(110.0, 16.0, 28.0), (130.0, 10.0, 20.0), (160.0, 7.0, 14.0)])
def test_a_page_that_paints_all_but_late_gets_pictures_about_as_far_apart_as_they_are_late(
    lag_ms: float, least: float, most: float
) -> None:
    """As where the processor is full of other work: fewer pictures would only show later what has happened."""
    found = rates(lambda came: came, lag_ms, 30.0)
    assert least < np.mean(found[100:]) < most


def test_a_page_that_is_very_late_gets_the_least() -> None:
    assert set(rates(lambda came: came, 600.0, 30.0)[250:]) == {LEAST_FPS}


def test_a_picture_less_in_a_second_is_how_seconds_are_counted() -> None:
    assert rates(lambda came: came - 1.0 if came < 7 else 0.5 * came, 20.0, 3.0)[-1] < 12.0
    assert max(rates(lambda came: came - 1.0, 20.0, 10.0)[50:]) == FULL_FPS


def test_of_few_pictures_too_a_page_that_skips_many_gets_no_more() -> None:
    assert max(rates(lambda came: min(came, 3.0), 20.0, 20.0)[100:]) < 8.0

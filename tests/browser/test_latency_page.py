"""The page of `farhand calibrate latency` in a browser: what it draws, and its reading of this host's clock."""

import time
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.host_clock import MonotonicClock
from farhand.calibration.latency.page import PatternPage
from farhand.calibration.latency.pattern import HOLD_MS, pattern_of, sequence


@pytest.mark.long
def test_the_page_draws_the_pattern_and_reports_it_on_this_hosts_clock(browser: Any) -> None:
    with PatternPage(MonotonicClock(), "token") as served:
        page = browser.new_page()
        page.goto(served.url)
        begin_ns = time.monotonic_ns()
        page.click("#start")
        page.wait_for_function("document.getElementById('words').textContent.startsWith('Done')", timeout=60_000)
        end_ns = time.monotonic_ns()
        report = served.wait(0.0)
        page.close()
    assert report is not None
    shown = pattern_of(report)
    assert begin_ns < shown.drawn_ns[0] < shown.drawn_ns[-1] < end_ns
    lasted_s = (shown.drawn_ns[-1] - shown.drawn_ns[0]) / NS_PER_S
    assert lasted_s == pytest.approx((len(sequence()) - 1) * HOLD_MS / 1000, abs=0.5)
    # Where a bit begins, the page shows that bit's own level.
    at_bits_ns = shown.drawn_ns[0] + np.arange(len(sequence()) - 1) * HOLD_MS * 1_000_000
    drawn = np.interp(at_bits_ns, shown.drawn_ns.astype(float), shown.levels)
    assert np.corrcoef(drawn, sequence()[:-1])[0, 1] > 0.95

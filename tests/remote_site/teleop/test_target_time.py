"""The time of a sample's target: steady though the measured offset of the clocks jumps, and never far from it."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.messages.hand import ClockSync
from remote_site.session.samples import Accepted
from remote_site.teleop.tool_target import MOST_PREDICTED_NS, TargetTime
from tests.remote_site.remote_loop import hand

FRAME_MS, MEASURED_EACH = 33, 30  # samples, between two measurements of the offset
TRANSIT_MS, UNCERTAIN_MS = 150.0, 120.0


def sample(capture_ms: float, offset_ms: float = 0.0, uncertain_ms: float = UNCERTAIN_MS) -> Accepted:
    """A sample that the sender's clock stamps, and the clocks' offset as it was measured."""
    capture_ns, offset_ns, uncertain_ns = (round(ms * NS_PER_MS) for ms in (capture_ms, offset_ms, uncertain_ms))
    clock = ClockSync(remote_minus_local_ns=offset_ns, uncertainty_ns=uncertain_ns, measured_ns=capture_ns)
    born_ns = capture_ns + offset_ns - uncertain_ns
    return Accepted(hand(1, capture_ns, clock=clock), np.zeros(3), None, born_ns, new_session=False)


def times_ms(
    offsets_ms: list[float], uncertain_ms: float = UNCERTAIN_MS, transit_ms: float = TRANSIT_MS
) -> list[float]:
    """The targets' times after the true exposures, for measured offsets that each hold for a second."""
    time, after = TargetTime(), []
    for k in range(len(offsets_ms) * MEASURED_EACH):
        exposed_ms = 1000.0 + k * FRAME_MS
        told = sample(exposed_ms, offsets_ms[k // MEASURED_EACH], uncertain_ms)
        after.append(time.of(told, round((exposed_ms + transit_ms) * NS_PER_MS)) / NS_PER_MS - exposed_ms)
    return after


def test_no_more_than_a_part_of_the_way_is_predicted() -> None:
    assert times_ms([0.0] * 3) == pytest.approx([TRANSIT_MS - MOST_PREDICTED_NS / NS_PER_MS] * 90)
    assert times_ms([0.0] * 3, transit_ms=40.0) == pytest.approx([0.0] * 90)


def test_a_measured_offset_that_jumps_hardly_moves_the_time() -> None:
    offsets = list(np.random.default_rng(3).uniform(-15.0, 15.0, 30))
    steps = np.abs(np.diff(times_ms(offsets)))
    assert steps.max() < 0.2  # each measurement moved it by 15 ms at once


def test_a_near_site_is_believed_at_once() -> None:
    after = times_ms([0.0, 5.0, -5.0], uncertain_ms=0.4, transit_ms=5.0)
    assert after[MEASURED_EACH] == pytest.approx(5.0, abs=0.1)
    assert after[2 * MEASURED_EACH] == pytest.approx(-5.0, abs=0.1)


def test_a_clock_that_was_set_is_followed_as_far_as_its_measurement_is_trusted() -> None:
    assert times_ms([0.0, 1000.0], transit_ms=40.0)[MEASURED_EACH] == pytest.approx(1000.0, abs=0.25 * UNCERTAIN_MS)

"""The stamps of an FR3's states: no later than they come, never back, near the quickest, whatever both clocks do."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from remote_site.drivers.franka.robot_watch import RobotTime

ZERO_NS = 5_000 * NS_PER_MS


def stamped(robot_ms: np.ndarray, arrival_ms: np.ndarray) -> np.ndarray:
    time = RobotTime()
    stamps = [
        time.stamp(round(r * NS_PER_MS), ZERO_NS + round(a * NS_PER_MS))
        for r, a in zip(robot_ms, arrival_ms, strict=True)
    ]
    return (np.array(stamps) - ZERO_NS) / NS_PER_MS


@pytest.mark.parametrize("rate", [1.0, 1.0001, 0.9999, 0.5])
def test_a_stamp_is_late_by_the_quickest_transit_only(rate: float) -> None:
    random = np.random.default_rng(3)
    robot = np.arange(2000.0)
    true = robot / rate
    arrival = np.maximum.accumulate(true + 0.2 + random.exponential(0.3, 2000))
    stamps = stamped(robot, arrival)
    assert (stamps <= arrival + 1e-6).all()
    assert (np.diff(stamps) >= 0).all()
    late = (stamps - true)[200:]
    assert late.max() < 1.0
    assert late.min() > 0.1 - 100 * (1 / rate - 1)


def test_states_that_wait_are_not_taken_for_new_ones() -> None:
    robot = np.arange(400.0)
    arrival = robot + 0.2
    arrival[200:230] = 230.2  # the process stood still for 30 ms, and then got all of them
    late = stamped(robot, arrival) - robot
    assert np.abs(late - 0.2).max() < 1e-6


@pytest.mark.parametrize("ahead_ms", [60.0, 10_000.0])
@pytest.mark.parametrize("at", [1, 300])
def test_one_time_that_lies_ahead_bars_no_later_state(ahead_ms: float, at: int) -> None:
    robot = np.arange(600.0)
    arrival = robot + 0.2
    robot[at] += ahead_ms
    stamps = stamped(robot, arrival)
    late = np.delete(arrival - stamps, at)
    assert np.abs(late - 0.0).max() < 1e-6


def test_a_robot_that_begins_its_time_anew_is_stamped_by_it_from_the_second_state_on() -> None:
    robot = np.arange(600.0)
    arrival = robot + 0.2
    robot[300:] += 10_000.0
    late = arrival - stamped(robot, arrival)
    assert np.abs(np.delete(late, 300)).max() < 1e-6

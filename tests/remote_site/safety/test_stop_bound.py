"""A stop that may take longer than configured is refused, and the speed that is named as the cure is the right one."""

import re

import pytest

from common.errors import ConfigError
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.stop_bound import check_stops, longest_stops
from tests.remote_site.remote_loop import arm

MODEL, _ = arm()


def refusal(speed: float, longest_ms: float) -> str:
    """Of an arm with little jerk at a fraction of its speed; empty where it may start."""
    limits = JointLimits.from_model(MODEL, RobotConfig(jerk_rad_s3=40.0, speed=speed))
    try:
        check_stops(limits, speed, longest_ms)
    except ConfigError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("speed", [1.0, 0.5, 0.3, 0.15])
@pytest.mark.parametrize("longest_ms", [600.0, 400.0, 130.0, 60.0])
def test_the_speed_that_is_named_as_the_cure_is_the_greatest_that_cures(speed: float, longest_ms: float) -> None:
    said = refusal(speed, longest_ms)
    words = re.search(r"robot\.speed = ([0-9.]+) or less", said)
    slower = [step / 100 for step in range(1, 100) if step / 100 < speed]
    curing = [fraction for fraction in slower if not refusal(fraction, longest_ms)]
    assert (float(words[1]) if words else None) == (max(curing, default=None) if said else None)


def test_a_stop_of_exactly_the_longest_time_is_allowed() -> None:
    limits = JointLimits.from_model(MODEL, RobotConfig(jerk_rad_s3=40.0))
    longest_ms = 1000.0 * max(longest_stops(limits))
    check_stops(limits, 1.0, longest_ms)
    with pytest.raises(ConfigError, match="may take"):
        check_stops(limits, 1.0, longest_ms - 0.01)
    cured_ms = 1000.0 * max(longest_stops(limits.scaled_speed(0.29)))
    assert "robot.speed = 0.29 or less" in refusal(1.0, cured_ms)

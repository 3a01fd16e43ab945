"""Commands cease in full motion: setpoints and robot stop as the safety figures promise, with every driver."""

import math

import msgspec
import pytest

from tests.contracts.driver_stands import (
    CONFIG,
    c500c_stand,
    kinematic_stand,
    simulated_stand,
)
from tests.contracts.stops import measured_stop

ROBOT = msgspec.structs.replace(CONFIG.robot, start_deg=(math.degrees(-1.5), 0.0, -45.0, 0.0, -45.0, 0.0))
REACH_M = 0.7
PERIOD_S = 1 / 15
# With 10 rad/s² and 100 rad/s³: speed, still accelerating, time and travel of the jerk-limited stop.
PROMISED = (
    (0.5, False, 0.144, 0.025),
    (1.0, False, 0.200, 0.070),
    (2.5, False, 0.352, 0.306),
    (0.5, True, 0.300, 0.129),
    (2.5, True, 0.502, 0.620),
)


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "accelerating", "seconds", "travel_m"), PROMISED)
@pytest.mark.parametrize(
    ("stand", "lag_s"), [(kinematic_stand, 0.0), (simulated_stand, 0.02), (c500c_stand, 4 * PERIOD_S + 0.03)]
)
def test_the_stop_is_as_short_as_promised(stand, lag_s, speed, accelerating, seconds, travel_m):
    stop = measured_stop(stand(robot=ROBOT), speed, 100.0, accelerating=accelerating)
    assert stop.speed == pytest.approx(speed, rel=0.03)
    assert stop.sent_s <= seconds + 0.004
    assert stop.sent_s >= seconds - 0.02
    assert REACH_M * stop.sent_rad == pytest.approx(travel_m, rel=0.03)
    assert stop.robot_s <= seconds + lag_s + 0.004
    assert REACH_M * stop.robot_rad <= REACH_M * (stop.sent_rad + stop.behind_rad) + 0.001
    assert REACH_M * stop.beyond_rad < 0.0005  # the robot goes no further than it was sent

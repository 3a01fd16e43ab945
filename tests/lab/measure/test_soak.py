"""Seconds in which everything goes wrong: no driver receives anything beyond a limit, however control stalls."""

import pytest

from lab.measure.soak.worst_commands import ROBOTS, soak
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.safety.clearance import TOLERANCE

ROUNDING = 1.00001
SECONDS = 8.0


# Each seed lets enough go wrong in a few seconds; `make bench` runs ten minutes of it.
@pytest.mark.parametrize(("name", "seed"), [("kinematic", 27), ("simulated", 32), ("c500c, emulated", 20)])
def test_whatever_goes_wrong_the_driver_receives_nothing_beyond_a_limit(name, seed):
    figures = soak(ROBOTS[name], SECONDS, seed)
    assert figures["commands"] > 10 * SECONDS
    assert figures["engagements"] >= 2
    assert figures["fraction of time engaged"] > 0.2
    assert figures["control stalls"] >= 2
    assert figures["robot faults seen"] >= 1
    assert figures["values not finite"] == 0
    assert figures["speed, fraction of limit"] <= ROUNDING
    assert figures["acceleration, fraction of limit"] <= ROUNDING
    assert figures["jerk between commands, fraction of limit"] <= ROUNDING / LEAST_FRACTION
    assert figures["speed between commands, fraction of limit"] <= ROUNDING / LEAST_FRACTION
    assert figures["minimum distance, mm"] >= figures["required distance, mm"]
    assert figures["joint beyond its limit, rad"] <= 1e-6
    assert figures["tool further outside than when its segment began, mm"] <= 1e3 * TOLERANCE
    assert figures["moving commands after disengagement"] == 0
    assert figures["rest after the last obeyed sample, ms beyond the bound"] <= 0
    assert figures["oldest sample obeyed, fraction of the age limit"] <= 1

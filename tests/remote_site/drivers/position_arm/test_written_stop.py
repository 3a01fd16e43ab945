"""The stop that is written comes at the arm's rate, and the arm's own one once it can be at rest."""

import numpy as np
import pytest

from common.clock import NS_PER_S
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stop_time
from tests.contracts.driver_stands import SETUP
from tests.contracts.position_arms import ServoArm
from tests.remote_site.drivers.position_arm.driven_arm import TURN_MS, DrivenArm

SPEED = 0.8


class TimedArm(ServoArm):
    """Keeps when it was written and stopped."""

    written_ns: list[int]
    stopped_ns: list[int]

    def write(self, positions: np.ndarray) -> None:
        self.written_ns.append(self.clock.now_ns())
        super().write(positions)

    def stop(self) -> None:
        self.stopped_ns.append(self.clock.now_ns())
        super().stop()


@pytest.mark.parametrize("rate_hz", [50.0, 70.0])
def test_a_stop_is_written_at_the_arms_rate_and_its_own_comes_once_it_can_be_at_rest(rate_hz: float) -> None:
    driven = DrivenArm(TimedArm, rate_hz=rate_hz, written_ns=[], stopped_ns=[]).active().at_speed(SPEED)
    motion = JointMotion(driven.arm.goal, SPEED * np.eye(6)[0], np.zeros(6))
    first, begun_ns = len(driven.arm.written_ns), driven.clock.now_ns()
    driven.driver.stop()
    driven.turns(1500)
    assert np.diff(driven.arm.written_ns[first:]).mean() == pytest.approx(NS_PER_S / rate_hz, rel=0.02)
    (stopped_ns,) = driven.arm.stopped_ns
    rests_s = stop_time(motion, SETUP.limits) + driven.driver.capabilities.longest_lag_s
    assert (stopped_ns - begun_ns) / NS_PER_S == pytest.approx(rests_s, abs=1 / rate_hz + TURN_MS / 1000)

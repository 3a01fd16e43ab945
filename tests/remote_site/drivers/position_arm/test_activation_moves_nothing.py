"""An activation moves no position arm: not one that hangs from where it was sent, nor one that is misread."""

import math

import numpy as np
import pytest

from common.clock import NS_PER_S
from common.errors import DriverError
from remote_site.drivers.position_arm.arm_stop import HANGS_RAD, RESTS_RAD_S, HeldPosture
from remote_site.kinematics.joints import JointMotion
from tests.contracts.driver_stands import SETUP
from tests.contracts.position_arms import BrakingArm, ServoArm, StopsHard
from tests.remote_site.drivers.position_arm.driven_arm import START, DrivenArm

FIRST, SECOND = np.eye(6)[:2]


class HangingArm(ServoArm):
    """Its load holds it `hang` rad below its goal, which a stop leaves as it is."""

    hang = 0.04
    loaded = SECOND

    def move(self) -> None:
        now_ns = self.clock.now_ns()
        elapsed_s, self._moved_ns = (now_ns - self._moved_ns) / 1e9, now_ns
        rest = self.goal - self.hang * self.loaded
        self.q = rest + (self.q - rest) * math.exp(-elapsed_s / self.lag_s)

    def stop(self) -> None:
        self.calls.append("stop")
        self.move()


class HangingBrakingArm(HangingArm):
    """The same of an arm that stops by its own means: at rest its stop changes nothing."""

    writes_stop = False


class SettlingArm(HangingArm):
    """Its own stop takes where it is as its goal: it sinks once more by what it hangs."""

    writes_stop = False
    hang = 0.02
    is_stopped = False

    def write(self, positions: np.ndarray) -> None:
        self.is_stopped = False
        super().write(positions)

    def stop(self) -> None:
        super().stop()
        if not self.is_stopped:
            self.is_stopped, self.goal = True, self.q


class MisreadArm(ServoArm):
    """Its second joint is read off by `off` rad; its servo knows better."""

    off = 0.0

    def read(self) -> np.ndarray:
        super().read()
        return np.asarray(self.q + self.off * SECOND)


class MisreadBrakingArm(BrakingArm):
    """The same of an arm that stops by its own means."""

    off = 0.0

    def read(self) -> np.ndarray:
        super().read()
        return np.asarray(self.q + self.off * SECOND)


@pytest.mark.parametrize("kind", [HangingArm, HangingBrakingArm, SettlingArm])
def test_an_arm_that_hangs_below_its_goal_sinks_by_no_activation(kind: type[ServoArm]) -> None:
    driven = DrivenArm(kind).active()
    driven.command(0.0)
    driven.turns(600)
    hung = driven.arm.q.copy()
    for _ in range(5):
        driven.driver.stop()
        driven.turns(500)
        driven.activate_again(600)
    assert driven.arm.q == pytest.approx(hung, abs=1e-6)


@pytest.mark.parametrize("kind", [MisreadArm, MisreadBrakingArm])
@pytest.mark.parametrize("off", [-1.0, 0.089, 0.3])
def test_an_arm_that_is_read_farther_away_than_it_can_hang_is_not_activated_there(
    kind: type[ServoArm], off: float
) -> None:
    driven = DrivenArm(kind).active()
    driven.command(0.0)
    driven.turns(300)
    driven.driver.stop()
    driven.turns(500)
    driven.arm.off = off
    driven.turns(500)
    rested = driven.arm.q.copy()
    with pytest.raises(DriverError, match="check its sensor"):
        driven.driver.activate(driven.reading().q)
    driven.turns(100)
    assert driven.arm.q == pytest.approx(rested, abs=1e-9)
    driven.arm.off = 0.0
    driven.turns(500)
    driven.driver.activate(driven.reading().q)


@pytest.mark.parametrize("kind", [MisreadArm, MisreadBrakingArm])
def test_an_arm_that_is_misread_by_no_more_than_it_can_hang_stays_where_it_is(kind: type[ServoArm]) -> None:
    driven = DrivenArm(kind).active()
    driven.command(0.0)
    driven.turns(300)
    driven.driver.stop()
    driven.turns(500)
    driven.arm.off = 0.04
    driven.turns(500)
    rested = driven.arm.q.copy()
    driven.activate_again(300)
    assert driven.arm.q == pytest.approx(rested, abs=1e-6)


@pytest.mark.parametrize("silent_ms", [0, 400])
@pytest.mark.parametrize("kind", [ServoArm, BrakingArm])
def test_an_arm_that_was_stopped_in_motion_is_activated_where_it_rests(kind: type[ServoArm], silent_ms: float) -> None:
    driven = DrivenArm(kind).active().at_speed(1.5)
    driven.turns(silent_ms)  # beyond the time-out, which stops it, too
    driven.driver.stop()
    driven.turns(1500)
    rested = driven.arm.q.copy()
    assert abs(rested[0] - START[0]) > 0.1
    driven.activate_again(300)
    assert driven.arm.q == pytest.approx(rested, abs=0.01)


def test_an_arm_that_was_stopped_before_it_was_where_it_was_sent_stays_where_it_rests() -> None:
    driven = DrivenArm(StopsHard).active().at_speed(1.0)
    driven.command(0.3)
    driven.turns(10)
    driven.driver.stop()
    driven.turns(500)
    rested = driven.arm.q.copy()
    assert 0.005 < START[0] + 0.3 - rested[0] < 0.05
    driven.activate_again(100)
    assert driven.arm.q == pytest.approx(rested, abs=1e-6)


def test_an_arm_that_is_led_to_rest_hangs_where_it_was_led() -> None:
    driven = DrivenArm(HangingArm, loaded=FIRST).active().at_speed(1.5)
    driven.driver.stop()
    driven.turns(1500)
    rested = driven.arm.q.copy()
    driven.activate_again(300)
    assert driven.arm.q == pytest.approx(rested, abs=1e-6)


@pytest.mark.parametrize(("speed", "held"), [(RESTS_RAD_S, 0.01), (2 * RESTS_RAD_S, 0.0)])
def test_a_joint_is_known_to_hold_where_it_was_sent_unless_it_was_in_motion(speed: float, held: float) -> None:
    posture = HeldPosture(6, 0.1, brakes=True)
    motion = JointMotion(START, speed * SECOND, np.zeros(6))
    posture.sent(motion, NS_PER_S)
    posture.stopped(motion, SETUP.limits, NS_PER_S)
    assert posture.hang(SETUP.joint_names, START, START - 0.01 * SECOND)[1] == pytest.approx(held)


def test_an_arm_that_hangs_as_far_as_one_may_is_activated_and_one_that_hangs_farther_is_not() -> None:
    posture, sent = HeldPosture(6, 0.1, brakes=False), np.zeros(6)
    assert posture.hang(SETUP.joint_names, sent, HANGS_RAD * SECOND) == pytest.approx(-HANGS_RAD * SECOND)
    with pytest.raises(DriverError, match="check its sensor"):
        posture.hang(SETUP.joint_names, sent, 1.0001 * HANGS_RAD * SECOND)

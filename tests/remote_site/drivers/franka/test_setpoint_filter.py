"""What becomes of setpoints that come early, late or not at all: a smooth motion, near the one that was meant."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.franka.played_motion import PlayedMotion
from remote_site.drivers.franka.robot_limits import FR3
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker
from tests.present import present
from tests.remote_site.drivers.franka.fake_robot import SETUP

BEGIN_NS = 1000 * NS_PER_MS
AIM_MS, TICK_MS = 700, 4


class Hand:
    """Goes to a new posture every 700 ms, as fast as the limits allow, and says so each tick, some of them late."""

    def __init__(self, late_ms: float, left_out: float) -> None:
        self._random = np.random.default_rng(7)
        self._late_ms, self._left_out = late_ms, left_out
        self._follower = JerkLimitedTracker(SETUP.limits, SETUP.dt)
        self._waiting: list[JointCommand] = []
        self._start = self._target = present(SETUP.start)
        self.motion = JointMotion.at_rest(self._start)
        self._seq = 0

    def due(self, ms: int) -> JointCommand | None:
        """The newest setpoint that has come by then."""
        if ms % AIM_MS == 0:
            low, high = SETUP.limits.lower, SETUP.limits.upper
            self._target = np.clip(self._start + self._random.uniform(-0.5, 0.5, 7), low, high)
        if ms % TICK_MS == 0:
            self._follower.reset(self.motion)
            followed = self._follower.track(JointMotion.at_rest(self._target))
            assert isinstance(followed, JointMotion)
            self.motion = followed
            self._seq += 1
            if self._random.random() >= self._left_out:
                t_ns = BEGIN_NS + round((ms + abs(self._random.normal(0.0, self._late_ms))) * NS_PER_MS)
                m = self.motion
                self._waiting.append(JointCommand(self._seq, t_ns, m.q, m.dq, m.ddq, GripperCommand.KEEP))
        come = [each for each in self._waiting if each.t_ns <= BEGIN_NS + ms * NS_PER_MS]
        self._waiting = [each for each in self._waiting if each.t_ns > BEGIN_NS + ms * NS_PER_MS]
        return come[-1] if come else None


def followed(hand: Hand, ms: int) -> tuple[PlayedMotion, Array, float]:
    """What is sent in each millisecond (ms, 7), and how far it is from what was meant, at most, rad."""
    arm = PlayedMotion(present(SETUP.start), present(SETUP.start), SETUP)
    sent, off = [], 0.0
    for at in range(ms):
        now_ns = BEGIN_NS + at * NS_PER_MS
        if (command := hand.due(at)) is not None:
            arm.add(command)
        sent.append(arm.step(1, now_ns))
        off = max(off, float(np.abs(sent[-1] - hand.motion.q).max()))
    return arm, np.array(sent), off


@pytest.mark.slow
@pytest.mark.parametrize(("late_ms", "left_out"), [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0), (1.0, 0.1)])
def test_setpoints_out_of_time_stay_within_the_robots_limits(late_ms: float, left_out: float) -> None:
    arm, sent, off = followed(Hand(late_ms, left_out), 6000)
    assert arm.fault is None
    speed, acceleration, jerk = (np.abs(np.diff(sent, k, axis=0)).max(axis=0) / 0.001**k for k in (1, 2, 3))
    assert (speed > 0.3 * SETUP.limits.velocity).all()
    assert (speed <= FR3.velocity).all()
    assert (acceleration <= FR3.acceleration).all()
    assert (jerk <= 0.3 * FR3.jerk).all()
    assert off < 0.03  # four ticks at full speed


def test_what_comes_in_time_is_followed_without_lag() -> None:
    hand = Hand(0.0, 0.0)
    arm = PlayedMotion(present(SETUP.start), present(SETUP.start), SETUP)
    lag = 0.0
    for at in range(4000):
        if (command := hand.due(at)) is not None:
            arm.add(command)
            behind = hand.motion  # as of now
        q = arm.step(1, BEGIN_NS + at * NS_PER_MS)
        if at % TICK_MS == TICK_MS - 1:  # a tick after the setpoint
            lag = max(lag, float(np.abs(q - behind.q - SETUP.dt * behind.dq).max()))
    assert lag < 0.002
    assert arm.obeyed == 1000

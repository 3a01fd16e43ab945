"""A hand sample's path to the encoders: shown once the measured joints are as far as its first command."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.messages.robot import Traced
from remote_site.drivers.link import RobotReport
from remote_site.kinematics.joints import JointMotion
from remote_site.runtime.tracing import Tracing
from remote_site.session.samples import Accepted
from tests.present import present
from tests.remote_site.remote_loop import hand

LAG_MS = 25


def accepted(seq: int, capture_ms: int) -> Accepted:
    sample = hand(seq, capture_ms * NS_PER_MS)
    return Accepted(sample, np.array(sample.wrist), None, sample.capture_ns, False, 1.0, (0.0, 0.0, 0.0))


def commanded(t_ms: float, speed: float) -> JointMotion:
    return JointMotion(np.array([0.5, speed * t_ms / 1e3]), np.array([0.0, speed]), np.zeros(2))


def reading(t_ms: int, speed: float, obeyed_seq: int | None) -> RobotReport:
    """The second joint follows what is commanded 25 ms late."""
    q = np.array([0.5, speed * (t_ms - LAG_MS) / 1e3])
    rest = JointMotion.at_rest(q)
    return RobotReport(t_ms * NS_PER_MS, q, np.array([0.0, speed]), None, None, obeyed_seq, rest, True)


def run(speed: float, every_ms: int = 32, until_ms: int = 320) -> tuple[Tracing, list[Traced]]:
    """Samples each obeyed 20 ms after their exposure by command number t/4, which the robot takes 6 ms later."""
    tracing, traced = Tracing(), []
    sample = None
    for t_ms in range(0, until_ms, 4):
        if t_ms % every_ms == 0:
            sample = accepted(t_ms // every_ms, t_ms - 20 + 1000)
        tracing.obey(present(sample), t_ms // 4, t_ms * NS_PER_MS, commanded(t_ms, speed))
        tracing.see(reading(t_ms, speed, (t_ms - 6) // 4))
        if tracing.traced is not None and tracing.traced not in traced:
            traced.append(tracing.traced)
    return tracing, traced


@pytest.mark.parametrize("speed", [0.4, -0.4])
def test_every_sample_is_shown_as_late_as_the_arm_follows(speed):
    _, traced = run(speed)
    assert len(traced) >= 9
    assert [one.seq for one in traced] == list(range(len(traced)))
    for one in traced:
        assert LAG_MS <= (one.encoder_ns - one.command_ns) / NS_PER_MS < LAG_MS + 4
        assert one.command_ns < one.motion_ns < one.encoder_ns


def test_samples_that_come_faster_than_the_arm_follows_are_traced_all_the_same():
    _, traced = run(0.4, every_ms=8)
    assert len(traced) > 30
    assert {(one.encoder_ns - one.command_ns) // NS_PER_MS for one in traced} <= {25, 26, 27, 28}


def test_an_arm_that_stands_shows_nothing():
    tracing, traced = run(0.0)
    assert not traced
    obeyed = tracing.reported()
    assert obeyed is not None
    assert obeyed.motion_ns is not None


def test_a_robot_that_never_comes_as_far_is_given_up():
    tracing, seen = Tracing(), []
    tracing.obey(accepted(1, 0), 1, NS_PER_MS, commanded(0, 0.4))
    for t_ms in range(0, 3000, 100):
        tracing.see(reading(t_ms, 0.0, 1)._replace(q=np.array([0.5, -1.0 if t_ms < 1500 else 1.0])))
        seen.append(tracing.traced)
    assert seen == [None] * 30


def at(tracing: Tracing, t_ms: int, obeyed_seq: int | None) -> tuple[int, int | None]:
    """What is reported once the robot is seen: the sample's number, and when its command reached the robot, ms."""
    tracing.see(reading(t_ms, 0.0, obeyed_seq))
    told = present(tracing.reported())
    return told.seq, None if told.motion_ns is None else told.motion_ns // NS_PER_MS


def test_a_quick_robots_sample_is_told_first_without_its_motion_and_then_with_it():
    tracing = Tracing()
    assert tracing.reported() is None
    tracing.obey(accepted(1, 100), 10, 120 * NS_PER_MS, commanded(120, 0.0))
    assert [at(tracing, 125, 9), at(tracing, 130, 10), at(tracing, 134, 11)] == [(1, None), (1, 130), (1, 130)]


def test_a_slow_robots_motion_is_told_though_newer_samples_are_obeyed_by_now():
    tracing = Tracing()
    for seq in (1, 2, 3):
        tracing.obey(accepted(seq, 100 * seq), 10 * seq, (100 * seq + 20) * NS_PER_MS, commanded(0, 0.0))
    assert at(tracing, 330, None) == (3, None)
    assert at(tracing, 400, 25) == (2, 400)  # the newest that the robot has come to
    assert at(tracing, 410, 26) == (3, None)
    assert [at(tracing, 450, 30), at(tracing, 454, 31)] == [(3, 450), (3, 450)]

"""A fast hand: the joints do not overshoot a target that turns hard, nor the target a hand that turns."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.config import ControlConfig
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.target_predictor import TargetPredictor
from remote_site.reasons import Code
from remote_site.safety.guard import JointGuard, Passed
from tests.remote_site.arms_followed import smooth
from tests.remote_site.motion.aimed import aim
from tests.remote_site.remote_loop import TICK_NS, arm

_, LIMITS = arm()
DT, AXIS = TICK_NS / NS_PER_S, np.eye(6)[0]
PERIOD_MS = 33


def swung(amplitude: float, hz: float, t: float) -> JointMotion:
    """Joint 1 swinging from rest at time zero."""
    w = 2 * np.pi * hz
    motion = amplitude * (1 - np.cos(w * t)), amplitude * w * np.sin(w * t), amplitude * w * w * np.cos(w * t)
    return JointMotion(*(value * AXIS for value in motion))


@pytest.mark.parametrize("fraction", [0.5, 0.7, 0.9])
def test_a_joint_follows_whatever_its_own_acceleration_can_do(fraction: float) -> None:
    """Braking for a target at rest in a steady frame swung up to twice as far, and never stopped doing so."""
    amplitude = fraction * LIMITS.acceleration[0] / (2 * np.pi * 0.75) ** 2
    tracker = JerkLimitedTracker(LIMITS, DT)
    tracker.reset(JointMotion.at_rest(np.zeros(6)))
    off = []
    for k in range(1500):
        motion = tracker.track(swung(amplitude, 0.75, k * DT))
        assert isinstance(motion, JointMotion)
        off.append(motion.q[0] - swung(amplitude, 0.75, (k + 1) * DT).q[0])
    assert np.abs(off[250:]).max() < 0.01 * amplitude


@pytest.mark.parametrize("behind", [0.2, 1.0])
def test_a_joint_that_is_behind_an_accelerating_target_does_not_overshoot_it(behind: float) -> None:
    tracker = JerkLimitedTracker(LIMITS, DT)
    tracker.reset(JointMotion.at_rest(-behind * AXIS))
    off = []
    for k in range(400):
        t = k * DT
        slowing = JointMotion(*(value * AXIS for value in (1.5 * t - 0.9375 * t * t, 1.5 - 1.875 * t, -1.875)))
        motion = tracker.track(slowing)
        assert isinstance(motion, JointMotion)
        off.append(float(motion.q[0] - 1.5 * (t + DT) + 0.9375 * (t + DT) ** 2))
    assert max(off) < 1e-3
    assert abs(off[-1]) < 1e-3


@pytest.mark.parametrize("jerk", [20.0, 40.0, 100.0])
def test_a_joint_with_little_jerk_is_never_carried_beyond_its_speed_by_a_target_that_accelerates(jerk: float) -> None:
    limits = replace(LIMITS, jerk=np.full(6, jerk))
    guard, most = JointGuard(limits, DT), 0.0
    for acceleration in (3.0, 4.0, 5.0, 6.0, 8.0):
        tracker = JerkLimitedTracker(limits, DT)
        tracker.reset(JointMotion.at_rest(np.zeros(6)))
        for k in range(500):
            t, sent = min(k * DT, 3.4 / acceleration), tracker.motion
            way = acceleration * t * t / 2 + 3.4 * (k * DT - t)
            goal = JointMotion(way * AXIS, acceleration * t * AXIS, acceleration * (t == k * DT) * AXIS)
            motion = tracker.track(goal)
            assert isinstance(motion, JointMotion)
            verdict = guard.check(motion, sent)
            assert isinstance(verdict, Passed) or verdict.reason.code is Code.POSITION
            most = max(most, limits.pace(motion.dq, motion.ddq))
    assert most == pytest.approx(1.0)


def stopping_at(t: float, stops_s: float) -> JointMotion:
    """Joint 1 at 1 rad/s, and from `stops_s` on braking at 6 rad/s²."""
    braking_s = min(max(t - stops_s, 0.0), 1.0 / 6.0)
    braking = 6.0 if 0.0 < t - stops_s < 1.0 / 6.0 else 0.0
    way = min(t, stops_s) + braking_s - 3.0 * braking_s**2
    speed = 1.0 - 6.0 * braking_s
    return JointMotion(way * AXIS, speed * AXIS, -braking * AXIS)


@pytest.mark.slow
@pytest.mark.parametrize("behind", [0.1, 0.3, 1.0])
def test_a_joint_that_catches_up_with_a_target_is_never_carried_beyond_where_the_target_stops(behind: float) -> None:
    """Caught up with as quickly as limits allow, a target that stopped at the wrong time was overrun by 0.18 rad."""
    for stops_s in np.arange(0.1, 1.0, 0.05):
        tracker = JerkLimitedTracker(LIMITS, DT)
        tracker.reset(JointMotion.at_rest(-behind * AXIS))
        motions = [tracker.track(stopping_at(k * DT, stops_s)) for k in range(500)]
        ways = [motion.q[0] for motion in motions if isinstance(motion, JointMotion)]
        rest = stopping_at(10.0, stops_s).q[0]
        assert max(ways) < rest + 1e-3
        assert ways[-1] == pytest.approx(rest, abs=1e-6)


def predicted(hand: Callable[[float], float], age_ms: float, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Times in s and the target in m of a hand that is seen every 33 ms."""
    predictor, pending = TargetPredictor(1, ControlConfig()), [k * PERIOD_MS for k in range(1, 400)]
    times, places = [], []
    for k in range(round(seconds / DT)):
        now_ms = k * TICK_NS / NS_PER_MS
        while pending and pending[0] + age_ms <= now_ms:
            t_ms = pending.pop(0)
            aim(predictor, t_ms * NS_PER_MS, np.array([hand(t_ms / 1e3)]), k * TICK_NS)
        times.append(k * DT)
        places.append(predictor.at(k * TICK_NS)[0][0])
    return np.array(times), np.array(places)


@pytest.mark.parametrize("age_ms", [20, 60, 150])
def test_the_target_hardly_goes_beyond_a_swinging_hand_however_old_its_samples(age_ms: float) -> None:
    times, places = predicted(lambda t: 0.04 * np.sin(2 * np.pi * 0.75 * t), age_ms, 6.0)
    assert np.abs(places[times > 2.0]).max() < 1.08 * 0.04


@pytest.mark.parametrize("age_ms", [20, 60, 150])
def test_the_target_hardly_goes_beyond_where_a_reaching_hand_stops(age_ms: float) -> None:
    times, places = predicted(lambda t: 0.2 * smooth((t - 1.0) / 0.8), age_ms, 3.0)
    assert places.max() < 0.2 + 0.012
    assert np.abs(places[times > 2.4] - 0.2).max() < 1e-3


def quick_start(t: float) -> float:
    """The hand at 0.1 m/s, which after a second accelerates at 4 m/s² to 0.5 m/s, and goes on so; m."""
    gaining_s = min(max(t - 1.0, 0.0), 0.1)
    return 0.1 * t + 2.0 * gaining_s**2 + 0.4 * max(t - 1.1, 0.0)


def test_after_a_quick_start_the_target_stays_behind_for_a_while_as_its_end_may_come_at_once() -> None:
    times, places = predicted(quick_start, 40.0, 2.2)
    off = places - [quick_start(t) for t in times]
    assert np.abs(off[(times > 0.8) & (times < 1.0)]).max() < 2e-3
    assert off[(times > 1.2) & (times < 1.5)].max() < -0.01
    assert np.abs(off[times > 2.0]).max() < 2e-3

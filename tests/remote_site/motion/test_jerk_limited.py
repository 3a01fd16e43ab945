"""The follower: on a steady target without lag, on a sudden one without overshoot, and never outside the limits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array, transform
from remote_site.config import RemoteConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.config import ControlConfig
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.target_predictor import TargetPredictor, joint_target_predictor
from remote_site.motion.target_tracker import choose_target_tracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.reasons import Code, Reason
from remote_site.safety.guard import JointGuard, Passed
from remote_site.teleop.config import prediction
from tests.remote_site.arms_followed import figure_of_eight
from tests.remote_site.motion.aimed import aim
from tests.remote_site.remote_loop import TICK_NS, arm

DT = 0.004
MODEL, LIMITS = arm()
START = np.radians([0.0, 0.0, -45.0, 0.0, -45.0, 0.0])
EXACT = ControlConfig(position_gain=1.0, velocity_gain=1.0)


def tracked(follower: JerkLimitedTracker, target: Array, speed: float = 1.0) -> JointMotion:
    motion = follower.track(JointMotion.at_rest(target), speed)
    assert isinstance(motion, JointMotion), motion
    return motion


def follow(predictor, samples, seconds, latency_s=0.0):
    """A follower whose predictor gets `samples` {t_s: q}: its motions, and how often the guard demanded the stop."""
    follower, guard = JerkLimitedTracker(LIMITS, DT), JointGuard(LIMITS, DT)
    follower.reset(JointMotion.at_rest(START))
    predictor.reset(0, START)
    pending = sorted(samples.items())
    history, refusals = [], 0
    for k in range(round(seconds / DT)):
        now_ns = round(k * DT * NS_PER_S)
        while pending and pending[0][0] + latency_s <= k * DT:
            t, q = pending.pop(0)
            aim(predictor, round(t * NS_PER_S), q, now_ns)
        before = follower.motion
        motion = follower.track(JointMotion(*predictor.at(now_ns)))
        assert isinstance(motion, JointMotion)
        if not isinstance(guard.check(motion, before), Passed):
            refusals += 1
            follower.reset(guard.stop(before))
        history.append(follower.motion)
    return history, refusals


def ramp(speed, seconds, fps=30.0):
    """Joint 1 at constant speed, then at rest."""
    times = np.arange(1, round((seconds + 1) * fps)) / fps
    return {t: START + np.eye(6)[0] * speed * min(t, seconds) for t in times}


@pytest.mark.parametrize(("latency_s", "lag_s"), [(0.015, 0.0), (0.035, 0.0), (0.09, 0.052), (0.2, 0.162)])
def test_a_steady_target_is_followed_without_stutter_and_lags_by_what_samples_are_older_than_40_ms(latency_s, lag_s):
    history, refusals = follow(joint_target_predictor(MODEL, LIMITS, EXACT), ramp(0.5, 2.0), 1.9, latency_s=latency_s)
    assert refusals == 0
    times = np.arange(1, len(history) + 1) * DT
    settled = times > 1.5  # it catches up slowly with a target that moves from the first
    q = np.array([motion.q[0] for motion in history])
    dq = np.array([motion.dq[0] for motion in history])
    assert np.abs(q - 0.5 * (times - lag_s))[settled].max() < 2e-3
    assert np.abs(dq - 0.5)[settled].max() < 0.01


def test_a_step_is_reached_without_overshoot():
    target = START + np.array([0.5, -0.3, 0.2, 1.0, -0.4, -2.0])
    follower = JerkLimitedTracker(LIMITS, DT)
    follower.reset(JointMotion.at_rest(START))
    path = np.array([tracked(follower, target).q for _ in range(400)])
    assert np.abs(path[-1] - target).max() < 1e-9
    assert ((path - target) * np.sign(START - target) >= -1e-8).all()


def test_the_speed_scale_slows_the_follower():
    follower = JerkLimitedTracker(LIMITS, DT)
    follower.reset(JointMotion.at_rest(START))
    speeds = [np.abs(tracked(follower, START + 1.0, 0.25).dq) for _ in range(100)]
    assert np.max(speeds, axis=0) == pytest.approx(0.25 * LIMITS.velocity)


def test_a_sample_that_comes_after_the_course_has_ended_counts_as_any_other():
    predictor, way = joint_target_predictor(MODEL, LIMITS, EXACT), 0.02 * np.eye(6)[0]
    predictor.reset(0, START)
    aim(predictor, 40 * NS_PER_MS, START + 0.04 * way, 100 * NS_PER_MS)
    place, speed = (number[0] / way[0] for number in predictor.at(250 * NS_PER_MS)[:2])
    assert (place, speed) == (pytest.approx(0.14, abs=0.02), pytest.approx(0.0, abs=0.5))  # at 160 ms, 20 behind
    aim(predictor, 80 * NS_PER_MS, START + 0.08 * way, 255 * NS_PER_MS)
    place, moving = (number[0] / way[0] for number in predictor.at(314 * NS_PER_MS)[:2])
    assert place > 0.2  # moving to 0.314
    assert moving > 1.0


@pytest.mark.parametrize(("stretch", "carried"), [(1.0, False), (4.0, True)])
def test_an_arm_that_a_long_t_soft_makes_slower_is_carried_on_for_longer(stretch, carried):
    config = RemoteConfig()
    tracker, target, at_ms = (
        choose_target_tracker(config.robot, prediction(config), MODEL, LIMITS),
        MODEL.forward(START),
        0,
    )
    tracker.reset(0, START)
    there, places = JointMotion.at_rest(START), {}
    for now_ms in range(0, 830, 2):
        if now_ms % 32 == 0 and now_ms < 600:
            at_ms = now_ms
            target = transform(target[:3, :3], target[:3, 3] + [0.0, 0.002, 0.0])
            tracker.aim(ToolSample(at_ms * NS_PER_MS, at_ms * NS_PER_MS, target, None, None, stretch))
        there = tracker.at(now_ms * NS_PER_MS, there, 1.0)
        places[now_ms - at_ms] = there.q[0]
    earlier, later = places[160], places[230]
    assert bool(later - earlier > 0.003) is carried


def test_a_course_ends_after_its_prediction_and_comes_to_rest_there():
    predictor = joint_target_predictor(
        MODEL, LIMITS, ControlConfig(position_gain=1.0, velocity_gain=1.0, predict_ms=60.0)
    )
    predictor.reset(0, START)
    for k in range(1, 31):
        aim(predictor, k * 33 * NS_PER_MS, START + 0.01 * k, k * 33 * NS_PER_MS)
    last_ns = 30 * 33 * NS_PER_MS
    q, dq, _ = predictor.at(last_ns + 1000 * NS_PER_MS)
    assert dq == pytest.approx(np.zeros(6), abs=1e-6)
    assert q == pytest.approx(START + 0.3 + 0.01 * 60 / 33, abs=1e-3)


def test_a_course_has_no_jumps():
    rng = np.random.default_rng(2)
    predictor = joint_target_predictor(MODEL, LIMITS, ControlConfig())
    predictor.reset(0, START)
    step_ns = NS_PER_MS // 4
    before = predictor.at(0)
    for k in range(1, 2400):
        now_ns = k * step_ns
        if k % 132 == 0:
            aim(predictor, now_ns - 15 * NS_PER_MS, START + rng.normal(0, 0.02, 6), now_ns)
        here = predictor.at(now_ns)
        assert np.abs(here[0] - before[0]).max() < 1e-3
        assert np.abs(here[1] - before[1]).max() < 0.05
        before = here


def test_a_course_begins_to_move_no_harder_than_the_joints_can():
    """Joints that cannot keep to it would catch up one after the other, and swing the tool off the path."""
    predictor, way, hardest = (
        joint_target_predictor(MODEL, LIMITS, ControlConfig()),
        np.array([0.1, 0.05, -0.1, 0.1, 0.1, 0.1]),
        0.0,
    )
    predictor.reset(0, START)
    before = np.zeros(6)
    for k in range(1, 500):
        t = k * TICK_NS / NS_PER_S
        if k % 8 == 0:
            share = min(max((t - 0.5) / 0.6, 0.0), 1.0)
            aim(predictor, k * TICK_NS, START + way * share**3 * (10 - 15 * share + 6 * share**2), k * TICK_NS)
        speed = predictor.at(k * TICK_NS)[1]
        hardest, before = max(hardest, np.max(np.abs(speed - before) / DT / LIMITS.acceleration)), speed
    assert hardest < 1.0


def test_noise_at_rest_is_damped_and_a_hand_that_moves_is_followed():
    """Noise of 1 mm on each axis is 1.73 mm in all; a hand that starts to move is followed within 2 mm all the same."""
    rng, noise = np.random.default_rng(6), []
    predictor = TargetPredictor(3, ControlConfig())
    for k in range(5000):
        if k % 8 == 0:
            aim(predictor, k * TICK_NS, rng.normal(0, 1e-3, 3), k * TICK_NS)
        noise.append(predictor.at(k * TICK_NS)[0])
    assert np.sqrt(np.mean(np.sum(np.square(noise[250:]), axis=1))) < 1.25e-3
    predictor, off = TargetPredictor(3, ControlConfig()), []
    for k in range(1500):
        place, _ = figure_of_eight(k * TICK_NS / NS_PER_S)
        if k % 8 == 0:
            aim(predictor, k * TICK_NS, place, k * TICK_NS)
        off.append(np.linalg.norm(predictor.at(k * TICK_NS)[0] - place))
    assert np.mean(off) < 0.7e-3
    assert max(off) < 2.2e-3


def test_old_samples_and_samples_at_once_do_not_upset_a_course():
    predictor = joint_target_predictor(MODEL, LIMITS, EXACT)
    predictor.reset(100, START)
    aim(predictor, 100, START + 1.0, 200)
    assert predictor.at(300)[0] == pytest.approx(START)
    aim(predictor, 101, START + 0.01, 200)
    assert np.abs(predictor.at(200)[1]).max() <= 1.0 + 1e-9


def test_a_target_outside_the_limits_ends_at_the_limit_slowly_enough():
    samples = {t: START + np.eye(6)[4] * 3.0 * t for t in np.arange(1, 60) / 30}
    history, _ = follow(joint_target_predictor(MODEL, LIMITS, EXACT), samples, 2.0)
    q5 = np.array([motion.q[4] for motion in history])
    assert q5.max() <= LIMITS.upper[4] + 1e-9
    assert q5[-1] == pytest.approx(LIMITS.upper[4], abs=1e-3)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(
    st.lists(
        st.tuples(st.lists(st.floats(-2, 2), min_size=6, max_size=6), st.integers(1, 30), st.sampled_from("tsva")),
        min_size=1,
        max_size=12,
    )
)
def test_whatever_the_target_the_joints_stay_within_velocity_acceleration_and_jerk(sequence):
    follower, guard = JerkLimitedTracker(LIMITS, DT), JointGuard(LIMITS, DT)
    follower.reset(JointMotion.at_rest(START))
    for values, ticks, kind in sequence:
        target = np.clip(START + np.array(values), LIMITS.lower, LIMITS.upper)
        moved = {kind: 10.0 ** np.array(values) * np.sign(values) if kind == "a" else np.array(values)}
        goal = JointMotion(target, moved.get("v", np.zeros(6)), moved.get("a", np.zeros(6)))
        for _ in range(ticks):
            before = follower.motion
            motion = follower.stop() if kind == "s" else follower.track(goal)
            assert isinstance(motion, JointMotion)
            verdict = guard.check(motion, before)
            if not isinstance(verdict, Passed):
                assert verdict.reason.code is Code.POSITION
                follower.reset(guard.stop(before))


def test_a_target_that_is_not_finite_gives_a_reason_and_no_motion():
    follower = JerkLimitedTracker(LIMITS, DT)
    follower.reset(JointMotion.at_rest(START))
    result = follower.track(JointMotion.at_rest(START * np.nan))
    assert isinstance(result, Reason)
    assert result.code is Code.NO_TRAJECTORY
    assert np.array_equal(follower.motion.q, START)
    assert isinstance(follower.track(JointMotion.at_rest(START + 0.1)), JointMotion)


@pytest.mark.parametrize("acceleration", [3.0, 10.0])
def test_a_joint_at_full_speed_against_its_target_has_a_motion_too(acceleration):
    follower = JerkLimitedTracker(replace(LIMITS, acceleration=np.full(6, acceleration)), DT)
    shoulder = np.eye(6)[1]
    for speed in np.linspace(-3.14, -2.0, 12):
        for target in np.linspace(2.0, 2.8, 5):
            for change in (4.0, 10.0, 30.0):
                follower.reset(JointMotion(START, speed * shoulder, np.zeros(6)))
                goal = JointMotion(START + 0.02 * shoulder, target * shoulder, change * shoulder)
                assert isinstance(follower.track(goal), JointMotion)


@pytest.mark.parametrize("scale", [1.0, 0.1, 0.01])
def test_a_slowed_joint_is_no_faster_than_it_may_be(scale):
    follower, shoulder = JerkLimitedTracker(LIMITS, DT), np.eye(6)[1]
    follower.reset(JointMotion.at_rest(START))
    for k in range(500):
        goal = JointMotion(START + min(k * DT, 1.0) * shoulder, (k * DT < 1.0) * shoulder, np.zeros(6))
        planned = follower.track(goal, scale)
        assert isinstance(planned, JointMotion)
        assert planned.dq[1] <= scale * LIMITS.velocity[1] * 1.001

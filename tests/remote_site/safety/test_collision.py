"""Distances, collision avoidance and clearance: never within the margin, never far for NaN, retreat always possible."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.errors import ConfigError
from common.geometry import rotation_from_vector
from common.messages.robot import SessionState
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import CapsuleConfig, RobotConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code
from remote_site.safety.collision import ClearanceCache, CollisionModel
from remote_site.safety.config import CollisionConfig, FixtureConfig, SafetyConfig
from remote_site.safety.stopping import stops
from tests.remote_site.arms_followed import INDEX, THUMB
from tests.remote_site.remote_loop import (
    RemoteLoop,
    arm,
    assert_within_limits,
    clearance,
    hand,
)

MODEL, LIMITS = arm()
ROBOT = RobotConfig()
WIDE: dict[str, Any] = {"workspace_min_m": (-0.3, -0.6, 0.1), "workspace_max_m": (0.9, 0.6, 1.3)}


def collision(config=None, capsules=ROBOT.capsules):
    return CollisionModel.from_urdf(ROBOT.urdf, MODEL, capsules, config or CollisionConfig())


def test_the_gripper_is_as_far_from_the_table_as_its_capsules_say():
    """At the start the tool is level: its lowest capsule ends 35 mm below its axis, 868.5 mm up; the table at 558."""
    table = FixtureConfig(name="table", min_m=(0.3, -1.0, 0.0), max_m=(1.0, 1.0, 0.558))
    model = collision(CollisionConfig(fixtures=(table,)))
    posture = ROBOT.start.copy()
    posture[5] = 0.0
    pairs = [pair for pair in model.pairs_within(posture, 0.6) if pair.names == ("tool0", "table")]
    assert min(pair.distance for pair in pairs) == pytest.approx(0.8685 - 0.035 - 0.558, abs=1e-3)


def test_the_gradient_is_the_derivative_of_the_distance():
    model, rng, seen = collision(), np.random.default_rng(4), 0
    for _ in range(40):
        q = rng.uniform(LIMITS.lower, LIMITS.upper)
        before = model.distances(q)
        for pair in model.pairs_within(q, 0.3):
            if pair.distance < 0.005:
                continue  # inside each other the direction is arbitrary
            k = int(np.argmin(np.abs(before - pair.distance)))
            numeric = [(model.distances(q + e)[k] - model.distances(q - e)[k]) / 2e-4 for e in 1e-4 * np.eye(6)]
            seen += 1
            assert np.abs(numeric - pair.gradient).max() < 0.02
    assert seen > 50


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("joint", range(6))
def test_joints_that_are_not_finite_are_never_far_from_anything(value, joint):
    q = ROBOT.start.copy()
    q[joint] = value
    for model in (collision(), collision(CollisionConfig(fixtures=()))):
        model.distance(ROBOT.start)
        assert model.distance(q) == -math.inf
        assert not (model.clearances(q, np.zeros(6), 0.0) >= 0.0).any()
        assert (model.distances(q) == -math.inf).all()
        assert len(model.distances(q)) == len(model.distances(ROBOT.start))
        assert model.distances(q, np.arange(1)).tolist() == [-math.inf]


def test_what_an_earlier_measurement_leaves_is_never_more_than_the_distance():
    model, rng = collision(), np.random.default_rng(5)
    for _ in range(60):
        q = rng.uniform(LIMITS.lower, LIMITS.upper)
        before = model.distances(q)
        near = q + rng.normal(0, 0.05, 6)
        left = before - model.levers @ np.abs(near - q)
        assert (left <= model.distances(near) + 1e-5).all()
        travel = np.abs(near - q)
        used = model.levers @ travel
        assert (model.clearances(q, travel, left.min() - 1e-9) >= used).all()
        assert not (model.clearances(q, travel, left.min() + 1e-6) >= used).all()


def test_a_clearance_is_used_up_by_the_travel_from_where_it_was_noted():
    cache = ClearanceCache(np.array([[1.0, 0.5], [0.2, 1.0]]))
    cache.note([0.1, 0.2], np.array([0.3, 0.4]))
    assert cache.covers([0.1, 0.2], [0.0, 0.0])
    assert cache.covers([0.2, 0.2], [0.15, 0.0])
    assert not cache.covers([0.2, 0.2], [0.25, 0.0])
    assert not cache.covers([0.45, 0.2], [0.0, 0.0])


@pytest.mark.parametrize("clearance", [0.0, -0.01, np.nan, -np.inf])
def test_what_has_no_clearance_or_is_not_finite_is_never_covered(clearance):
    cache = ClearanceCache(np.array([[1.0, 0.5], [0.2, 1.0]]))
    assert not cache.covers([0.0, 0.0], [0.0, 0.0])
    cache.note([0.0, 0.0], np.array([0.3, clearance]))
    assert not cache.covers([0.0, 0.0], [0.0, 0.0])
    cache.note([0.0, 0.0], np.array([0.3, 0.4]))
    assert not cache.covers([np.nan, 0.0], [0.0, 0.0])
    assert not cache.covers([0.0, 0.0], [np.inf, 0.0])


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.integers(0, 2**32 - 1))
def test_the_cache_never_covers_what_a_lever_does_not(seed):
    rng = np.random.default_rng(seed)
    levers, clearances = rng.uniform(0, 1, (5, 3)) * rng.integers(0, 2, (5, 3)), rng.uniform(1e-4, 0.5, 5)
    cache = ClearanceCache(levers)
    cache.note([0.0, 0.0, 0.0], clearances)
    for _ in range(20):
        q, travel = rng.uniform(-0.5, 0.5, 3), rng.uniform(0, 0.2, 3)
        if cache.covers(q.tolist(), travel.tolist()):
            assert (levers @ (np.abs(q) + travel) <= clearances + 1e-12).all()


def test_unknown_links_are_refused_by_name():
    with pytest.raises(ConfigError, match=r"no link 'claw'.*tool0"):
        collision(capsules=(CapsuleConfig(link="claw", start_m=(0.0,) * 3, end_m=(0.0, 0.0, 0.1), radius_m=0.02),))
    with pytest.raises(ConfigError, match=r"ignored_pairs: no shelf; there are .*table"):
        collision(CollisionConfig(ignored_pairs=(("forearm", "shelf"),)))


def test_ignored_pairs_may_touch():
    every = len(collision().distances(ROBOT.start))
    fewer = collision(CollisionConfig(ignored_pairs=(("tool0", "table"),)))
    assert len(fewer.distances(ROBOT.start)) == every - len(ROBOT.capsules)


def test_a_way_to_rest_through_an_obstacle_is_not_clear_though_both_ends_are():
    post = FixtureConfig(name="post", min_m=(0.4, 0.10, 0.0), max_m=(0.5, 0.11, 1.2))
    safety = SafetyConfig(collision=CollisionConfig(margin_m=0.005, slow_m=0.02, fixtures=(post,)))
    around = clearance(RemoteConfig(safety=safety))
    motion = JointMotion.at_rest(ROBOT.start)
    motion.dq[0] = 3.0
    ends = stops(motion, LIMITS)
    rest = np.array([stop.end for stop in ends])
    assert around.collision.distance(motion.q) > 0.03
    assert around.collision.distance(rest) > 0.01
    assert not around.clear(ends)
    assert around.clear(stops(JointMotion.at_rest(ROBOT.start), LIMITS))


def wandering(loop, legs, seed, reach):
    """A hand that goes here and there, turning, and how near the arm comes to anything, m."""
    rng, wrist, turn, nearest = np.random.default_rng(seed), np.array([0.0, 0.0, 0.3]), np.zeros(3), []
    loop.hand_seq = 1000
    for _ in range(legs):
        goal, other = np.array([0.0, 0.0, 0.3]) + rng.uniform(-1, 1, 3) * reach, rng.uniform(-1, 1, 3)
        for _ in range(25):
            step = 0.12 * (goal - wrist)
            wrist = wrist + step * min(1.0, 0.025 / np.linalg.norm(step))
            turn = turn + 0.06 * (other - turn)
            points = {name: wrist + rotation_from_vector(turn) @ p for name, p in (("index", INDEX), ("thumb", THUMB))}
            loop.hand_seq += 1
            points = {name: tuple(point.tolist()) for name, point in points.items()}
            sample = hand(loop.hand_seq, loop.clock.now_ns(), tuple(wrist.tolist()), **points)
            for k in range(8):
                loop.tick(*([sample] if k == 0 else []))
                nearest.append(loop.distance())
    return np.array(nearest)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 8])
def test_whatever_the_hand_does_nothing_comes_nearer_than_the_margin(seed):
    loop = RemoteLoop(RemoteConfig(safety=SafetyConfig(**WIDE)))
    loop.run(8 * 31, lambda _t_ns: (0.0, 0.0, 0.3))
    nearest = wandering(loop, 6, seed, np.array([0.4, 0.4, 0.5]))
    margin = loop.config.safety.collision.margin_m
    assert nearest.min() >= margin
    assert nearest.min() < margin + 0.01  # it was tried
    assert loop.states[-1] is SessionState.ENGAGED
    assert_within_limits(loop)


def inside_the_margin():
    """A loop whose arm starts with the gripper 15 mm above a table that wants 40."""
    table = FixtureConfig(name="table", min_m=(0.3, -1.0, 0.0), max_m=(1.0, 1.0, 0.8185))
    safety = SafetyConfig(**WIDE, collision=CollisionConfig(margin_m=0.04, slow_m=0.1, fixtures=(table,)))
    loop = RemoteLoop(RemoteConfig(safety=safety))
    loop.run(8 * 31, lambda _t_ns: (0.0, 0.0, 0.3))
    assert loop.distance() < 0.02
    return loop


def moving(loop, speed_z, seconds=1.2):
    """The hand goes up or down; the distances along the path, m."""
    begin_ns, found = loop.clock.now_ns(), []
    for k in range(round(seconds * 250)):
        t = (loop.clock.now_ns() - begin_ns) / 1e9
        loop.hand_seq += 1
        sample = hand(loop.hand_seq, loop.clock.now_ns(), (0.0, 0.0, 0.3 + speed_z * t))
        loop.tick(*([sample] if k % 8 == 0 else []))
        found.append(loop.distance())
    return np.array(found)


@pytest.mark.slow
def test_an_arm_that_starts_inside_the_margin_only_retreats():
    loop = inside_the_margin()
    start = loop.distance()
    assert moving(loop, -0.1, 0.6).min() >= start - 1e-4
    assert loop.snapshot.reason.code is Code.OBSTACLE
    away = moving(loop, 0.15, 1.5)
    assert away[-1] > 0.04
    assert away.min() >= start - 1e-4
    assert_within_limits(loop)


def test_an_approach_becomes_slow_and_ends_without_starting_again():
    loop = RemoteLoop(RemoteConfig(safety=SafetyConfig(**WIDE)))
    loop.run(8 * 31, lambda _t_ns: (0.0, 0.0, 0.3))
    moving(loop, -0.25, 2.5)
    resting = len(loop.log)
    bottom = loop.clock.now_ns()
    for k in range(250):
        loop.hand_seq += 1
        sample = hand(loop.hand_seq, loop.clock.now_ns(), (0.0, 0.0, 0.3 - 0.25 * 2.5))
        loop.tick(*([sample] if k % 8 == 0 else []))
    _, dq, _ = loop.arrays()
    assert loop.clock.now_ns() > bottom
    assert np.abs(dq[resting + 100 :]).max() < 0.02
    assert loop.distance() >= 0.01

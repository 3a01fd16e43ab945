"""What avoids obstacles: nothing is changed that approaches nothing, and the nearest obstacle is named."""

import numpy as np
import pytest

from remote_site.config import RemoteConfig
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code
from remote_site.safety.collision_avoidance import BRAKING, SPARE, CollisionAvoidance
from remote_site.safety.config import CollisionConfig, FixtureConfig, SafetyConfig
from tests.remote_site.remote_loop import arm, collision_model

DT = 0.004
_, LIMITS = arm()
START = RemoteConfig().robot.start


def beside(*posts: FixtureConfig) -> CollisionAvoidance:
    """The avoidance of an arm among posts."""
    collision = CollisionConfig(fixtures=posts, slow_m=0.2)
    config = RemoteConfig(safety=SafetyConfig(collision=collision))
    return CollisionAvoidance(collision_model(config), collision, LIMITS, DT)


def post(name: str, left_m: float) -> FixtureConfig:
    """To the left of the tool."""
    return FixtureConfig(name=name, min_m=(0.4, left_m, 0.0), max_m=(0.5, left_m + 0.05, 1.2))


def turning(speed: float, acceleration: float = 0.0) -> JointMotion:
    """Joint 1 to the left."""
    return JointMotion(START, speed * np.eye(6)[0], acceleration * np.eye(6)[0])


@pytest.mark.parametrize(("near", "far"), [("post", "wall"), ("wall", "post")])
def test_the_nearest_obstacle_is_named(near: str, far: str) -> None:
    posts = [post(near, 0.12), post(far, 0.15)]
    for fixtures in (posts, posts[::-1]):
        aside = beside(*fixtures).turn_aside(START, JointMotion.at_rest(START + np.eye(6)[0]))
        assert aside.reason is not None
        assert aside.reason.code is Code.OBSTACLE
        assert near in aside.reason.sentence
        assert far not in aside.reason.sentence


def test_a_motion_that_is_slow_enough_or_leads_away_is_sent_as_it_is_planned() -> None:
    avoidance = beside(post("post", 0.12))
    pairs = avoidance.turn_aside(START, turning(0.0)).close_pairs
    for planned in (turning(0.01), turning(-2.0), turning(-2.0, -10.0), turning(0.5, -18.0)):
        assert avoidance.temper(planned, turning(0.0), pairs) is planned


def test_a_motion_that_is_too_fast_brakes_to_what_the_clearance_allows() -> None:
    avoidance, dq = beside(post("post", 0.12)), []
    sent = turning(0.3)
    for _ in range(200):
        pairs = avoidance.turn_aside(sent.q, turning(0.0)).close_pairs
        tempered = avoidance.temper(turning(1.0), sent, pairs)
        assert tempered is not None
        assert np.abs(tempered.ddq).max() <= LIMITS.acceleration[0] + 1e-9
        assert np.abs(tempered.ddq - sent.ddq).max() <= LIMITS.jerk[0] * DT + 1e-9
        sent = tempered
        dq.append(float(sent.dq[0]))
    pairs = avoidance.turn_aside(sent.q, turning(0.0)).close_pairs
    margin = CollisionConfig().margin_m + SPARE
    assert dq[-1] < 0.2
    for pair in pairs:
        assert -pair.gradient @ sent.dq <= 1.05 * BRAKING * (pair.distance - margin)

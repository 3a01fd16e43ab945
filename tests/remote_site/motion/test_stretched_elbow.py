"""A hand that goes out to full reach and back: slowly the tool keeps to the line, and it ends where it should."""

import math
from collections.abc import Callable
from itertools import pairwise

import msgspec
import numpy as np
import pytest

from common.geometry import Array
from common.messages.hand import HandArm
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.upright_arm import UprightArm
from remote_site.safety.config import CollisionConfig, SafetyConfig
from tests.remote_site.arms_followed import Followed, HandMotion, smooth
from tests.remote_site.remote_loop import arm, assert_within_limits

WIDE = SafetyConfig(workspace_min_m=(-2.0,) * 3, workspace_max_m=(2.0,) * 3, collision=CollisionConfig(fixtures=()))
CONFIG = RemoteConfig(robot=RobotConfig(start_deg=(0.0, -40.0, -50.0, 0.0, -45.0, 0.0)), safety=WIDE)
LOOSE = msgspec.structs.replace(CONFIG, control=msgspec.structs.replace(CONFIG.control, leash_m=1.0))
BEFORE_S, WAIT_S = 0.3, 0.5


def to_full_reach(short_of_m: float) -> Array:
    """The wrist's way (3,) in m in the base's axes from the start straight out, that much short of a straight elbow."""
    model, _ = arm(CONFIG)
    upright = UprightArm.from_model(model)
    target = upright.target(model.forward(CONFIG.robot.start))
    assert target is not None
    x, y, z = upright.centre(target)
    reach = np.array([x, y, z - upright.shoulder_height])
    way: Array = reach * ((upright.upper_arm + upright.forearm - short_of_m) / np.linalg.norm(reach) - 1.0)
    return way


def out_and_back(way: Array, seconds: float) -> HandMotion:
    """A hand along a way in the base's axes, that takes so long for it."""
    in_operator = np.array(CONFIG.mapping.base_R_operator).T @ way

    def motion(t: float) -> tuple[Array, Array]:
        part = smooth((t - BEFORE_S) / seconds) - smooth((t - BEFORE_S - seconds - WAIT_S) / seconds)
        return part * in_operator, np.zeros(3)

    return motion


def quick_places(seed: int) -> list[Array]:
    """Four places (3,) in m from the start, whose wrist is 0.5 to 30 mm short of full reach."""
    rng = np.random.default_rng(seed)
    out = to_full_reach(0.0)
    model, _ = arm(CONFIG)
    upright = UprightArm.from_model(model)
    reach = upright.upper_arm + upright.forearm
    start = out * (reach / np.linalg.norm(out)) - out  # of the wrist, from the shoulder
    places = []
    for short_m in np.exp(rng.uniform(np.log(0.0005), np.log(0.03), 4)):
        direction = out / np.linalg.norm(out) + rng.uniform(-0.35, 0.35, 3)
        places.append(direction / np.linalg.norm(direction) * (reach - short_m) - start)
    return places


def off_the_segment(places: Array, begin: Array, end: Array) -> Array:
    """The distance (n,) in m of places (n, 3) from a segment."""
    along = np.clip((places - begin) @ (end - begin) / ((end - begin) @ (end - begin)), 0.0, 1.0)
    off: Array = np.linalg.norm(places - begin - along[:, None] * (end - begin), axis=1)
    return off


def off_the_line(followed: Followed, way: Array) -> Array:
    """The tool's distance (n,) in m from the line between both ends."""
    return off_the_segment(followed.tools[:, :3, 3] - followed.start[:3, 3], np.zeros(3), way)


@pytest.mark.slow
@pytest.mark.parametrize("short_of_m", [0.0002, 0.003, 0.03])
def test_a_slow_hand_is_followed_on_its_line_out_to_the_stretched_elbow(short_of_m: float) -> None:
    way = to_full_reach(short_of_m)
    followed = Followed(CONFIG, out_and_back(way, 1.2), 4.5)
    assert off_the_line(followed, way).max() < 0.005
    assert math.dist(followed.tools[-1, :3, 3], followed.start[:3, 3]) < 0.0005


@pytest.mark.slow
@pytest.mark.parametrize("short_of_m", [0.0002, 0.003, 0.03])
@pytest.mark.parametrize("seconds", [0.4, 0.7])
def test_a_hand_too_fast_for_the_joints_is_followed_late_on_its_line(seconds: float, short_of_m: float) -> None:
    way = to_full_reach(short_of_m)
    followed = Followed(CONFIG, out_and_back(way, seconds), 2 * seconds + 2.3)
    assert off_the_line(followed, way).max() < 0.01
    assert math.dist(followed.tools[-1, :3, 3], followed.start[:3, 3]) < 0.0005
    assert followed.loop.refusals == 0
    assert_within_limits(followed.loop)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_quick_ways_near_full_reach_are_followed_late_on_their_lines(seed: int) -> None:
    places = [np.zeros(3), *quick_places(seed), np.zeros(3)]
    times = BEFORE_S + np.cumsum([0.0, *(max(math.dist(a, b) / 0.5, 0.3) for a, b in pairwise(places))])
    base_R_operator = np.array(CONFIG.mapping.base_R_operator)

    def motion(t: float) -> tuple[Array, Array]:
        leg = min(max(int(np.searchsorted(times, t)) - 1, 0), len(places) - 2)
        part = smooth((t - times[leg]) / (times[leg + 1] - times[leg]))
        return base_R_operator.T @ (places[leg] + part * (places[leg + 1] - places[leg])), np.zeros(3)

    followed = Followed(LOOSE, motion, times[-1] + 3.0)
    moved = followed.tools[:, :3, 3] - followed.start[:3, 3]
    off = np.min([off_the_segment(moved, a, b) for a, b in pairwise(places)], axis=0)
    assert off.max() < 0.01
    assert math.dist(followed.tools[-1, :3, 3], followed.start[:3, 3]) < 0.002
    assert_within_limits(followed.loop)


class Noisy(Followed):
    """The same for a tracker whose wrist is off by 2 mm, another way in every sample."""

    def _sample(self, t: float, motion: HandMotion, elbow: Callable[[float], Array] | None) -> HandArm:
        off = 0.002 * np.random.default_rng(round(t * 1e9)).standard_normal(3)
        return super()._sample(t, lambda t: (motion(t)[0] + off, motion(t)[1]), elbow)


def test_a_target_that_waits_does_not_follow_every_turn_of_the_samples_noise() -> None:
    way = np.array([0.0, 0.15, -0.1])
    followed = Noisy(RemoteConfig(safety=WIDE), out_and_back(way, 1.2), 5.0)
    off = np.linalg.norm(followed.tools[:, :3, 3] - followed.start[:3, 3] - followed.hands, axis=1)
    assert off.mean() < 0.04
    assert off[-200:].max() < 0.01

"""The closed form along the way of the tool's target: solutions on the straight way, close to each other."""

import numpy as np
import pytest

from common.geometry import Array, angle_between, rotation_from_vector, transform
from remote_site.kinematics.inverse import Solution, SphericalWristInverse, Unreachable
from remote_site.kinematics.upright_arm import SHOULDER_HOLD
from remote_site.motion.target_tracker import MOST, SPACING_RAD, PathInverse
from tests.remote_site.remote_loop import arm

MODEL, LIMITS = arm()
START = np.radians([0.0, 10.0, -70.0, 0.0, -40.0, 0.0])
TOOL = MODEL.forward(START).copy()


def beside(way: tuple[float, float, float], turn: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
    """A pose of the tool beside the start's."""
    return transform(rotation_from_vector(np.array(turn)) @ TOOL[:3, :3], TOOL[:3, 3] + way)


def begun() -> PathInverse:
    path = PathInverse(SphericalWristInverse(MODEL, LIMITS))
    path.reset(TOOL, START)
    return path


def solved(found: list[Solution] | Unreachable) -> list[Solution]:
    assert isinstance(found, list)
    return found


@pytest.mark.parametrize("way", [(0.0, 0.05, 0.0), (-0.05, 0.02, 0.03), (0.0, 0.3, 0.0)])
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.0, 0.2, 0.1)])
def test_the_solutions_are_spread_over_the_straight_way_and_the_last_is_the_targets(
    way: tuple[float, float, float], turn: tuple[float, float, float]
) -> None:
    path = begun()
    found = solved(path.along(beside(way, turn), 1.0, 1.0))
    tools = [MODEL.forward(solution.q).copy() for solution in found]
    for k, tool in enumerate(tools, 1):
        assert tool[:3, 3] - TOOL[:3, 3] == pytest.approx(np.array(way) * k / len(found), abs=1e-6)
        turned = angle_between(TOOL[:3, :3], tool[:3, :3])
        assert turned == pytest.approx(np.linalg.norm(turn) * k / len(found), abs=1e-6)
    apart = np.abs(np.diff([START, *(solution.q for solution in found)], axis=0)).max(axis=1)
    whole = np.abs(found[-1].q - START).max()
    assert len(found) == min(int(np.ceil(whole / SPACING_RAD)), MOST) > 1
    assert apart.max() < 3 * whole / len(found)
    assert path.q is found[-1].q
    back = path.to(TOOL, 1.0, 1.0)
    assert isinstance(back, Solution)
    assert back.q == pytest.approx(START, abs=1e-9)


@pytest.mark.parametrize("way", [(0.0, 0.0, 0.0), (0.0, 0.001, 0.0)])
def test_a_short_way_has_the_targets_solution_only(way: tuple[float, float, float]) -> None:
    path, again = begun(), begun()
    (only,) = solved(path.along(beside(way), 0.03, 1.0))
    directly = again.to(beside(way), 0.03, 1.0)
    assert isinstance(directly, Solution)
    assert only.q == pytest.approx(directly.q)
    assert path.q is only.q
    (still,) = solved(path.along(beside(way), 0.03, 1.0))
    assert still.q == pytest.approx(only.q)


def test_a_target_out_of_reach_changes_nothing() -> None:
    path = begun()
    assert isinstance(path.along(beside((3.0, 0.0, 0.0)), 0.03, 1.0), Unreachable)
    assert path.q is START
    (first, *_) = solved(path.along(beside((0.0, 0.05, 0.0)), 1.0, 1.0))
    assert np.abs(first.q - START).max() < 2 * SPACING_RAD


def test_whatever_can_be_reached_at_once_is_reached_along_the_way_too() -> None:
    """Also where the step by step way ends at a limit, or in a branch from which the target is not reached."""
    inverse, rng, reached = SphericalWristInverse(MODEL, LIMITS), np.random.default_rng(1), 0
    for _ in range(150):
        q = rng.uniform(LIMITS.lower, LIMITS.upper)
        pose = MODEL.forward(q).copy()
        turn = rotation_from_vector(rng.normal(0.0, 0.5, 3))
        target = transform(turn @ pose[:3, :3], pose[:3, 3] + rng.normal(0.0, 0.15, 3))
        path = PathInverse(inverse)
        path.reset(pose, q)
        found = path.along(target, 0.2, 1.0)
        assert isinstance(found, Unreachable) == isinstance(inverse.nearest(target, q, 0.2, 1.0), Unreachable)
        if not isinstance(found, Unreachable):
            assert MODEL.forward(path.q)[:3, 3] == pytest.approx(target[:3, 3], abs=SHOULDER_HOLD)
            reached += 1
    assert reached > 30

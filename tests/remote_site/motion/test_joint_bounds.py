"""The bounds of the joints' target: it converges as quickly as all joints can, and is hurried by the hardest."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.geometry import vector_from_rotation
from remote_site.motion.target_predictor import (
    SPEEDING,
    TOOL_M_S,
    TOOL_M_S2,
    TOOL_RAD_S,
    TOOL_RAD_S2,
    JointBounds,
    Unbounded,
)
from tests.remote_site.remote_loop import arm

MODEL, LIMITS = arm()
SLOWEST, WANTED = 20.0, 50.0
BOUNDS = JointBounds(MODEL, LIMITS, SLOWEST)
offsets = st.lists(st.sampled_from([0.0, 1e-20, 1e-3, 0.004, 0.01, 0.02, 0.1]), min_size=6, max_size=6)
speeds = st.lists(st.sampled_from([0.0, 0.05, 0.1, 0.2, 0.5]), min_size=6, max_size=6)


def needed(rate: float, off: list[float], dq_off: list[float]) -> float:
    """The fraction of its acceleration that a joint needs at the start at worst, of the one that needs most."""
    away, step = np.abs(off), np.abs(dq_off)
    return float(((rate * rate * away + 2 * rate * step) / LIMITS.acceleration).max())


@settings(max_examples=200, deadline=None, derandomize=True)
@given(offsets, speeds, st.sampled_from([1.0, -1.0]))
def test_the_target_converges_as_quickly_as_every_joints_acceleration_allows(
    off: list[float], dq_off: list[float], side: float
) -> None:
    rate = BOUNDS.convergence(WANTED, [side * away for away in off], dq_off)
    assert SLOWEST <= rate <= WANTED
    assert needed(rate, off, dq_off) <= 1.0 + 1e-9 or rate == SLOWEST
    if SLOWEST < rate < WANTED:
        assert needed(rate, off, dq_off) == pytest.approx(1.0)


def test_a_joint_that_is_only_too_fast_loses_its_speed_within_its_acceleration() -> None:
    for joint, speed in ((0, 0.2), (4, -0.4)):
        rate = BOUNDS.convergence(WANTED, [0.0] * 6, (speed * np.eye(6)[joint]).tolist())
        assert rate == pytest.approx(LIMITS.acceleration[joint] / (2 * abs(speed)))


@pytest.mark.parametrize("joint", range(6))
def test_the_effort_is_that_of_the_joint_which_needs_most(joint: int) -> None:
    still, one = [0.0] * 6, np.eye(6)[joint]
    hard, fast = (0.5 * one * LIMITS.acceleration).tolist(), (-0.5 * one * LIMITS.velocity).tolist()
    assert BOUNDS.effort(still, hard, 1.0) == pytest.approx(0.5)
    assert BOUNDS.effort(fast, still, 1.0) == 0.0  # a target slower than the arm may be needs none
    assert BOUNDS.effort(fast, still, 0.25) == pytest.approx(SPEEDING * (0.5 / 0.25 - 1.0))
    assert BOUNDS.effort(fast, hard, 0.45) == pytest.approx(0.5)


def test_the_effort_of_a_tools_target_is_that_of_its_way_or_of_its_turn() -> None:
    tool, still = Unbounded(), [0.0] * 6
    for k in range(3):
        way, turn = np.eye(6)[k], np.eye(6)[k + 3]
        assert tool.effort(still, (TOOL_M_S2 / 2 * way).tolist(), 1.0) == pytest.approx(0.5)
        assert tool.effort(still, (TOOL_RAD_S2 / 2 * turn).tolist(), 1.0) == pytest.approx(0.5)
        assert tool.effort((TOOL_M_S * way).tolist(), still, 0.5) == pytest.approx(SPEEDING)
        assert tool.effort((TOOL_RAD_S * turn).tolist(), still, 0.5) == pytest.approx(SPEEDING)


def test_the_speed_of_a_tool_is_that_of_its_way_and_of_its_turn() -> None:
    q, dq = np.array([0.3, -0.2, -1.0, 0.4, -0.9, 0.1]), np.array([0.3, 0.0, 0.4, 1.0, 2.0, -2.0])
    assert Unbounded().tool_speed(q.tolist(), dq.tolist()) == pytest.approx((0.5, 3.0))
    ahead, behind = (MODEL.forward(q + step * dq).copy() for step in (1e-5, -1e-5))
    turned = vector_from_rotation(ahead[:3, :3] @ behind[:3, :3].T)
    found = np.linalg.norm(ahead[:3, 3] - behind[:3, 3]) / 2e-5, np.linalg.norm(turned) / 2e-5
    assert BOUNDS.tool_speed(q.tolist(), dq.tolist()) == pytest.approx(found, rel=1e-5)

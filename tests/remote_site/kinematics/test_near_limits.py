"""The speed from which a joint can just stop: within a way, and before its limit."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.geometry import rotation_from_vector, transform
from remote_site.kinematics.config import SingularityConfig, SolverConfig
from remote_site.kinematics.differential import NEAR_LIMITS, RETURN_S, DifferentialInverse, Move
from remote_site.kinematics.limits import stoppable
from remote_site.safety.stopping import joint_stop
from tests.remote_site.arms_followed import SEVEN_AXES
from tests.remote_site.remote_loop import arm

DT = 0.004
MODEL, LIMITS = arm(SEVEN_AXES)
START = SEVEN_AXES.robot.start


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.floats(1e-4, 3.0), st.floats(0.5, 25.0), st.sampled_from([40.0, 100.0, 1000.0]))
def test_a_joint_with_the_speed_stops_in_just_the_way(way: float, acceleration: float, jerk: float) -> None:
    speed = stoppable(way, acceleration, jerk)
    assert joint_stop((0.0, speed, 0.0), acceleration, jerk).end == pytest.approx(way, rel=1e-9)
    assert stoppable(-way, acceleration, jerk) == 0.0


def steps(q: np.ndarray, base_T_target: np.ndarray, ticks: int) -> list[Move]:
    """The general solver's towards a target, from rest at `q`."""
    inverse, moves = DifferentialInverse(MODEL, LIMITS, SolverConfig(), SingularityConfig(), START), []
    last = Move.at_rest(q)
    for _ in range(ticks):
        last = inverse.step(last, base_T_target, np.zeros(6), 1.0, DT, None)
        moves.append(last)
    return moves


@pytest.mark.parametrize(
    ("shift", "turn"), [((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0)), ((0.0, 0.0, 0.0), (0.0, 0.0, 3.0))], ids=["way", "turn"]
)
def test_the_general_solver_leads_a_joint_to_its_limit_no_faster_than_it_can_stop_there(
    shift: tuple[float, float, float], turn: tuple[float, float, float]
) -> None:
    pose, q, most, nearest = MODEL.forward(START), START, 0.0, np.inf
    beyond = transform(pose[:3, :3] @ rotation_from_vector(np.array(turn)), pose[:3, 3] + shift)
    for move in steps(q, beyond, 800):
        columns = q - LIMITS.lower, LIMITS.upper - q, move.dq, LIMITS.acceleration, LIMITS.jerk
        for below, above, speed, acceleration, jerk in zip(*columns, strict=True):
            left = below if speed < 0.0 else above
            most = max(most, abs(speed) / max(stoppable(left, acceleration, jerk), 1e-6))
            nearest = min(nearest, left)
        q = move.q
    assert most == pytest.approx(NEAR_LIMITS)
    assert 0.0 <= nearest < 0.01


def test_a_joint_outside_its_limit_comes_back_the_faster_the_further_it_is_outside() -> None:
    q = START.copy()
    q[5] = LIMITS.upper[5] + 0.1
    moves = steps(q, MODEL.forward(q), 200)
    outside, speeds = (np.array(column) for column in zip(*((m.q[5], m.dq[5]) for m in moves), strict=True))
    outside -= LIMITS.upper[5]
    returning = np.flatnonzero(outside[:-1] < 0.055)[:40]  # once it has gained speed
    assert outside[returning].min() > 0.005
    assert speeds[returning + 1] == pytest.approx(-RETURN_S * outside[returning])
    assert outside[-1] < 1e-3

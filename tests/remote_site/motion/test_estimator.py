"""The estimate of a target's motion: how much of a sample's deviation changes position, velocity and acceleration."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.motion.config import ControlConfig
from remote_site.motion.estimator import TargetEstimator, Transition
from remote_site.motion.gains import FilterGains, Gains

CONFIG = ControlConfig()
REST = FilterGains(CONFIG.position_gain, CONFIG.velocity_gain, 0.0, CONFIG.glide_rad_s)
MOVING = FilterGains(
    CONFIG.moving_position_gain,
    CONFIG.moving_velocity_gain,
    CONFIG.moving_acceleration_gain,
    CONFIG.moving_glide_rad_s,
)


def gains(deviations: list[float]) -> FilterGains:
    """Those after all of the deviations."""
    found = Gains(CONFIG)
    found.reset(1)
    return [found.update([deviation]) for deviation in deviations][-1]


def test_the_gains_are_those_in_motion_for_deviations_to_one_side_and_never_more() -> None:
    for side in (1.0, -1.0):
        assert gains([0.01 * side] * 30) == pytest.approx(MOVING)
        for count in range(1, 30):
            assert all(np.array(gains([0.01 * side] * count)) <= np.array(MOVING) * (1 + 1e-9))


def test_the_gains_are_those_at_rest_for_deviations_to_both_sides() -> None:
    assert gains([0.01, -0.01] * 30) == pytest.approx(REST)


@pytest.mark.parametrize("period_ms", [17, 33])
@pytest.mark.parametrize(
    ("lost", "velocity", "acceleration"),
    [(0, MOVING.velocity, MOVING.acceleration), (1, 1 / 2, 1 / 4), (3, 1 / 4, 1 / 16)],
    ids=["none", "one", "three"],
)
def test_a_deviation_changes_the_estimates_by_their_gains_or_by_all_of_it_after_lost_samples(
    period_ms: int, lost: int, velocity: float, acceleration: float
) -> None:
    """Of a deviation e after an interval T, e / T of the velocity and e / T² of the acceleration is all that it says.

    For a sample that comes in time the gains are less; once samples are lost, it is the whole, and never more.
    """
    estimator = TargetEstimator(CONFIG, lambda q, dq: (q, dq))
    estimator.reset(0, [0.0])
    for k in (*range(1, 21), 21 + lost):
        t_ns = k * period_ms * NS_PER_MS
        elapsed_s = (t_ns - estimator.sample_ns) / NS_PER_S
        ((at, speed, change),) = Transition.over(elapsed_s).of(estimator.states)
        place = 2.0 * (t_ns / NS_PER_S) ** 3
        estimator.update(t_ns, np.array([place]), None, moving=True, settled=True)
    period_s, off = period_ms / 1e3, place - at
    after = estimator.states[0]
    assert after[0] - at == pytest.approx(MOVING.position * off, rel=0.1)
    assert after[1] - speed == pytest.approx(velocity * off / period_s)
    assert after[2] - change == pytest.approx(acceleration * off / period_s**2)

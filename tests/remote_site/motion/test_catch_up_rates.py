"""The rates at which a target that was left behind is caught up with, and the predictor that keeps to them."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from remote_site.motion.catch_up import CATCH_UP_M_S, CATCH_UP_RAD_S, LEARNING, decay_rate, slower_rate
from remote_site.motion.config import ControlConfig
from remote_site.motion.target_predictor import TargetPredictor

PERIOD_MS = 33
TICK_MS = 4
OVERSHOOT = 1.05  # of the estimated velocity


def test_little_is_caught_up_with_as_quickly_as_ever() -> None:
    assert slower_rate(20.0, (0.4 * CATCH_UP_M_S, 0.4 * CATCH_UP_RAD_S), 1.0) == 20.0
    assert decay_rate(20.0, (0.001, 0.0), 1.0) == 20.0


def test_the_slower_part_never_moves_faster_than_the_catch_up_speed() -> None:
    for drift in (0.05, 0.2, 2.0):
        slow = slower_rate(20.0, (drift, 0.0), 1.0)
        assert slow * drift / (20.0 - slow) == pytest.approx(CATCH_UP_M_S)
    assert decay_rate(20.0, (0.02, 0.0), 1.0) * 0.02 == pytest.approx(CATCH_UP_M_S)


def test_turns_have_a_bound_of_their_own() -> None:
    slow = slower_rate(20.0, (0.0, 2.0), 1.0)
    assert slow * 2.0 / (20.0 - slow) == pytest.approx(CATCH_UP_RAD_S)
    assert decay_rate(20.0, (0.001, 0.5), 1.0) * 0.5 == pytest.approx(CATCH_UP_RAD_S)


def test_what_the_target_needs_itself_is_left_to_it() -> None:
    assert slower_rate(20.0, (0.2, 0.0), 0.5) < slower_rate(20.0, (0.2, 0.0), 1.0)
    assert slower_rate(20.0, (0.2, 0.0), 0.0) == 0.0
    assert decay_rate(20.0, (0.02, 0.0), 0.0) == 0.0


def speeds(speed_m_s: float, silent_at: int = 0, age_ms: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Of a target that rests at 0: how far it is from the samples' steady motion (m), and how fast it goes (m/s).

    From the sample `silent_at` on some are missing, longer than they are predicted.
    """
    predictor, places, moving = TargetPredictor(6, ControlConfig()), [], []
    predictor.reset(-age_ms * NS_PER_MS, np.zeros(6))
    for k in range(60):
        now_ms = k * PERIOD_MS
        if not 0 < silent_at <= k < silent_at + 6:
            q = np.zeros(6)
            q[0] = speed_m_s * k * PERIOD_MS / 1e3
            predictor.aim((now_ms - age_ms) * NS_PER_MS + 1, q, now_ms * NS_PER_MS)
        for tick_ms in range(now_ms, now_ms + PERIOD_MS, TICK_MS):
            place, speed, _ = predictor.at(tick_ms * NS_PER_MS)
            places.append(place[0] - speed_m_s * (tick_ms + age_ms) / 1e3)
            moving.append(speed[0])
    return np.array(places), np.array(moving)


@pytest.mark.parametrize("speed_m_s", [0.02, 0.1, -0.1, 0.5])
def test_from_rest_the_target_catches_up_at_most_50_mm_a_second_beyond_the_samples(speed_m_s: float) -> None:
    places, moving = speeds(speed_m_s)
    assert abs(moving).max() <= OVERSHOOT * abs(speed_m_s) + CATCH_UP_M_S
    assert abs(moving[0]) < 0.01
    assert abs(places[-1]) < 0.1 * abs(places).max()


@pytest.mark.parametrize("age_ms", [20, 40, 80, 160])
@pytest.mark.parametrize("speed_m_s", [0.05, 0.1, 0.2])
def test_after_late_samples_as_well(speed_m_s: float, age_ms: int) -> None:
    _, moving = speeds(speed_m_s, 40, age_ms)
    after = moving[40 * len(moving) // 60 :]
    assert after.min() == pytest.approx(0.0, abs=0.15 * speed_m_s)
    assert speed_m_s + 0.02 < after.max() <= speed_m_s + 0.05


def test_later_samples_are_followed_as_quickly_as_ever() -> None:
    predictor = TargetPredictor(6, ControlConfig())
    predictor.reset(0, np.zeros(6))
    for k in range(1, LEARNING + 2):
        predictor.aim(k * PERIOD_MS * NS_PER_MS, np.zeros(6), k * PERIOD_MS * NS_PER_MS)
    moved = np.array([0.05, 0.0, 0.0, 0.0, 0.0, 0.0])
    now_ms = (LEARNING + 2) * PERIOD_MS
    predictor.aim(now_ms * NS_PER_MS, moved, now_ms * NS_PER_MS)
    assert max(predictor.at((now_ms + t) * NS_PER_MS)[1][0] for t in range(0, 60, TICK_MS)) > 2 * CATCH_UP_M_S

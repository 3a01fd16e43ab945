"""The rates at which a target that was left behind is caught up with, and the predictor that keeps to them."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from remote_site.motion.catch_up import CATCH_UP_M_S, CATCH_UP_RAD_S, LEARNING, CatchUp, decay_rate, slower_rate
from remote_site.motion.config import ControlConfig
from remote_site.motion.target_predictor import TargetPredictor
from tests.remote_site.motion.aimed import aim

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


@pytest.mark.parametrize("samples", [0, LEARNING + 1])
def test_what_may_decay_at_the_full_rate_is_no_slow_part_any_more(samples: int) -> None:
    catch_up = CatchUp(60 * NS_PER_MS, lambda _q, dq: (abs(dq[0]), 0.0))
    catch_up.reset(0, 20.0)
    for k in range(samples):
        catch_up.note_arrival(k * PERIOD_MS * NS_PER_MS, 1.0)
    assert catch_up.update_slow_part([0.0], [0.001], [0.0], 20.0, [0.001]) == [0.0]
    (slow,) = catch_up.update_slow_part([0.0], [0.02], [0.0], 20.0, [0.02])
    assert catch_up.rate * slow == pytest.approx(CATCH_UP_M_S)


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
            aim(predictor, (now_ms - age_ms) * NS_PER_MS + 1, q, now_ms * NS_PER_MS)
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


@pytest.mark.parametrize("age_ms", [20, 60, 160, 300])
@pytest.mark.parametrize("silent", [6, 8, 10])
@pytest.mark.parametrize("then_m_s", [-0.1, 0.0, 0.1, 0.2])
def test_whatever_the_hand_did_while_samples_were_missing(then_m_s: float, silent: int, age_ms: int) -> None:
    """It went 0.1 m/s before: taken for a course that went on, what it did meanwhile would count as a sudden turn."""
    predictor, fastest = TargetPredictor(6, ControlConfig()), 0.0
    predictor.reset(0, np.zeros(6))
    for k in range(1, 70):
        now_ms, place = k * PERIOD_MS + age_ms, (0.1 * min(k, 39) + then_m_s * max(k - 39, 0)) * PERIOD_MS / 1e3
        if not 40 <= k < 40 + silent:
            aim(predictor, k * PERIOD_MS * NS_PER_MS, place * np.eye(6)[0], now_ms * NS_PER_MS)
        speeds = [predictor.at(tick_ms * NS_PER_MS)[1][0] for tick_ms in range(now_ms, now_ms + PERIOD_MS, TICK_MS)]
        fastest = max(fastest, *np.abs(speeds)) if k >= 40 + silent else 0.0
    assert fastest <= OVERSHOOT * abs(then_m_s) + CATCH_UP_M_S


@pytest.mark.parametrize("age_ms", [40, 160, 300])
def test_when_samples_cease_the_target_goes_on_for_as_long_however_old_they_were(age_ms: int) -> None:
    predictor = TargetPredictor(6, ControlConfig())
    predictor.reset(0, np.zeros(6))
    for k in range(1, 60):
        q = 0.1 * k * PERIOD_MS / 1e3 * np.eye(6)[0]
        aim(predictor, k * PERIOD_MS * NS_PER_MS, q, (k * PERIOD_MS + age_ms) * NS_PER_MS)
        predictor.at((k * PERIOD_MS + age_ms) * NS_PER_MS)
    rest = predictor.at(10_000 * NS_PER_MS)[0][0]
    assert rest - q[0] == pytest.approx(0.1 * 0.1, abs=5e-4)  # 60 ms, and what is made up of their age


@pytest.mark.parametrize("predict_ms", [60.0, 0.0])
def test_later_samples_are_followed_as_quickly_as_ever(predict_ms: float) -> None:
    predictor = TargetPredictor(6, ControlConfig(predict_ms=predict_ms))
    predictor.reset(0, np.zeros(6))
    for k in range(1, LEARNING + 2):
        aim(predictor, k * PERIOD_MS * NS_PER_MS, np.zeros(6), k * PERIOD_MS * NS_PER_MS)
    moved = np.array([0.05, 0.0, 0.0, 0.0, 0.0, 0.0])
    now_ms = (LEARNING + 2) * PERIOD_MS
    aim(predictor, now_ms * NS_PER_MS, moved, now_ms * NS_PER_MS)
    assert max(predictor.at((now_ms + t) * NS_PER_MS)[1][0] for t in range(0, 60, TICK_MS)) > 2 * CATCH_UP_M_S

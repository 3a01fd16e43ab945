"""A resting arm with a noisy encoder reads as at rest and a slow one as moving; lag and cut-off are as stated."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.driver import RESTING_RAD_S
from remote_site.drivers.position_arm.readings import SpeedOverWindow

WINDOW_NS = 100 * NS_PER_MS
COUNT_RAD = 2 * np.pi / 4096
RATES = [10.0, 50.0, 100.0, 500.0]


def speeds(positions, rate_hz, jitter=None):
    """The speeds of one joint, with the times in s at which they were known."""
    window, found = SpeedOverWindow(WINDOW_NS), []
    for k, q in enumerate(positions):
        t_s = 1.0 + k / rate_hz + (0.0 if jitter is None else jitter[k])
        speed = window.add(round(t_s * NS_PER_S), np.array([q]))
        if speed is not None:
            found.append((t_s, speed[0]))
    return np.array(found).T


def test_no_speed_is_known_before_a_window_of_positions():
    window = SpeedOverWindow(WINDOW_NS)
    known = [window.add(k * 10 * NS_PER_MS, np.zeros(2)) is not None for k in range(12)]
    assert known == [False] * 10 + [True] * 2


@pytest.mark.parametrize("rate_hz", RATES)
def test_an_arm_that_rests_between_two_counts_of_its_encoder_is_at_rest(rate_hz):
    flicker = COUNT_RAD * np.random.default_rng(3).integers(0, 2, 5000)
    _, found = speeds(flicker, rate_hz)
    assert np.abs(found).max() == pytest.approx(COUNT_RAD / 0.1, rel=0.01)
    assert np.abs(found).max() < RESTING_RAD_S


@pytest.mark.parametrize("rate_hz", RATES)
def test_an_arm_that_rests_under_noise_is_at_rest(rate_hz):
    noise = np.random.default_rng(4).normal(0.0, 0.0003, 5000)
    assert np.abs(speeds(noise, rate_hz)[1]).max() < RESTING_RAD_S


@pytest.mark.parametrize("rate_hz", RATES)
@pytest.mark.parametrize("speed", [0.04, -0.04, 1.0])
def test_an_arm_that_moves_is_moving_at_its_speed(rate_hz, speed):
    rng, count = np.random.default_rng(5), 1000
    positions = COUNT_RAD * np.round(speed * np.arange(count) / rate_hz / COUNT_RAD)
    _, found = speeds(positions, rate_hz, rng.uniform(0.0, 0.1 / rate_hz, count))
    assert np.abs(found).min() > RESTING_RAD_S
    assert found.mean() == pytest.approx(speed, rel=0.02)


def test_it_shows_the_speed_of_half_a_window_ago():
    t_s = np.arange(0, 1000) / 500.0
    found_s, found = speeds(0.5 * t_s**2, 500.0)  # the speed is the time
    assert found == pytest.approx(found_s - 1.0 - 0.05, abs=1e-6)


@pytest.mark.parametrize(("hz", "passes"), [(0.5, 0.996), (4.43, 0.707), (10.0, 0.0)])
def test_its_cut_off_is_as_stated(hz, passes):
    t_s = np.arange(0, 5000) / 500.0
    _, found = speeds(np.sin(2 * np.pi * hz * t_s) / (2 * np.pi * hz), 500.0)
    assert np.sqrt(2 * np.mean(found**2)) == pytest.approx(passes, abs=0.01)

"""The hand's path behind the target: predictions at first, then samples, several of them where they are noisy."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from remote_site.motion.delayed_target import LONGEST_S
from remote_site.motion.target_path import TargetPath

DT = 0.004
INTERVAL_MS, AGE_MS = 32, 30


def curve(t_s: float) -> tuple[Array, Array]:
    """A pose (6,) on a parabola in every number, and its rate."""
    a, b, c = np.arange(6.0), np.linspace(-1.0, 1.0, 6), np.linspace(0.3, -0.2, 6)
    return a + b * t_s + c * t_s**2, b + 2 * c * t_s


def walked(off: float = 0.0, noise: float = 0.0, interval_ms: int = INTERVAL_MS, begin_ms: int = 0) -> TargetPath:
    """A path until two seconds, with predictions that are off, and samples with noise that are known AGE_MS later."""
    path, random = TargetPath(DT), np.random.default_rng(3)
    for ms in range(begin_ms, 2000, 4):
        if ms % interval_ms == 0:
            path.add(ms * NS_PER_MS, curve(ms / 1e3)[0] + noise * random.standard_normal(6))
        pose, rate = curve((ms - AGE_MS) / 1e3)
        path.predict(pose + off, rate)
    return path


NOW_NS = (1996 - AGE_MS) * NS_PER_MS


@pytest.mark.parametrize("delay_s", [0.0, 0.0371, 0.2, 0.95])
@pytest.mark.parametrize("interval_ms", [INTERVAL_MS, 200])
def test_the_path_is_passed_as_it_was_however_late(delay_s: float, interval_ms: int) -> None:
    pose, rate = walked(interval_ms=interval_ms).at(NOW_NS, delay_s)
    expected, moving = curve(NOW_NS / NS_PER_S - delay_s)
    assert pose == pytest.approx(expected, abs=1e-5)
    assert rate == pytest.approx(moving, abs=1e-4)


def test_the_longest_delay_is_still_on_the_path_of_cameras_at_120_hz() -> None:
    delay_s = LONGEST_S - 0.1
    pose, _ = walked(interval_ms=8, begin_ms=-6000).at(NOW_NS, delay_s)
    assert pose == pytest.approx(curve(NOW_NS / NS_PER_S - delay_s)[0], abs=1e-5)


def test_of_predictions_that_overshoot_the_less_is_left_the_longer_the_delay() -> None:
    path = walked(off=0.01)
    left = [path.at(NOW_NS, delay_s)[0][0] - curve(NOW_NS / NS_PER_S - delay_s)[0][0] for delay_s in (0.0, 0.04, 0.2)]
    assert left[0] == pytest.approx(0.01)
    assert 0.002 < left[1] < 0.008
    assert left[2] == pytest.approx(0.0, abs=1e-6)


def test_noise_is_averaged_the_more_the_longer_the_delay() -> None:
    def spread(delay_s: float) -> float:
        off = []
        for ms in range(1500, 1700, 5):
            pose, _ = path.at(ms * NS_PER_MS + round(delay_s * NS_PER_S), delay_s)
            off.append(pose - curve(ms / 1e3)[0])
        return float(np.std(off))

    path = walked(noise=0.002)
    assert spread(0.37) < 0.65 * spread(0.1)
    assert spread(0.37) < 0.0012


def test_samples_that_come_late_or_twice_are_left_out() -> None:
    path = walked()
    before = path.at(NOW_NS, 0.3)[0]
    path.add(1000 * NS_PER_MS, np.full(6, 9.0))
    assert path.at(NOW_NS, 0.3)[0] == pytest.approx(before)


def test_where_there_are_too_few_samples_predictions_serve_and_the_oldest_at_most() -> None:
    path = TargetPath(DT)
    for k in range(5):
        path.predict(np.full(6, float(k)), np.zeros(6))
    assert path.at(0, 2 * DT)[0] == pytest.approx(np.full(6, 2.0))
    assert path.at(0, 1.0)[0] == pytest.approx(np.zeros(6))

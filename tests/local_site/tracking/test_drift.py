"""The drift alarm: silent through noise and tracking losses, raised soon after a camera is bumped."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from common.clock import NS_PER_S
from local_site.calibration.triangulation import epipolar_residuals, fundamentals
from local_site.tracking.drift import DriftAlarm, DriftConfig
from tests.local_site.calibration.plate_cameras import ANGLES, camera

CALIBRATED_PX = 0.2
FPS = 30


def feed(alarm, seconds, residual_px, random, start_s=0.0, points=4):
    """The alarm's messages over this many seconds of noisy residuals."""
    words = []
    for k in range(int(seconds * FPS)):
        residuals = np.abs(random.normal(0.0, residual_px / 0.6745, points))
        words.append(alarm.feed(residuals, int((start_s + k / FPS) * NS_PER_S)))
    return words


@pytest.mark.parametrize("seed", range(3))
def test_noise_alone_never_rings(seed):
    assert set(feed(DriftAlarm(CALIBRATED_PX), 120, 1.2, np.random.default_rng(seed))) == {None}


def test_outliers_do_not_ring():
    random = np.random.default_rng(1)
    alarm = DriftAlarm(CALIBRATED_PX)
    for k in range(60 * FPS):
        residuals = np.abs(random.normal(0.0, 1.0, 4))
        residuals[: 2 if k % 3 == 0 else 1] = 200.0
        assert alarm.feed(residuals, k * NS_PER_S // FPS) is None


def test_a_bump_is_told_within_a_window_and_forgotten_when_it_is_over():
    random = np.random.default_rng(2)
    alarm = DriftAlarm(CALIBRATED_PX)
    feed(alarm, 30, 1.0, random)
    words = feed(alarm, 12, 5.0, random, start_s=30)
    assert words[-1] is not None
    assert "calibrate again" in words[-1]
    assert "1.0 px at the start, 0.2 px at calibration" in words[-1]
    assert feed(alarm, 12, 1.0, random, start_s=42)[-1] is None


def test_few_residuals_and_none_say_nothing():
    alarm = DriftAlarm(None, DriftConfig(min_residuals=50))
    for k in range(100):
        assert alarm.feed([] if k % 10 else [30.0, np.nan], k * NS_PER_S) is None


def test_a_turned_camera_rings_by_the_residuals_of_its_pixels():
    random = np.random.default_rng(4)
    left, right = (camera(angle) for angle in ANGLES)
    nod = Rotation.from_euler("x", 0.6, degrees=True).as_matrix()
    bumped = replace(right, camera_R_operator=nod @ right.camera_R_operator, translation=nod @ right.translation)
    of_pairs = fundamentals([left.projection, right.projection])
    alarm = DriftAlarm(CALIBRATED_PX)
    words = []
    for k in range(40 * FPS):
        points = random.uniform(0.3, 0.7, (4, 3))
        seen = (left, right if k < 20 * FPS else bumped)
        pixels = np.stack([c.pixels(points) for c in seen], axis=1) + random.normal(0.0, 1.0, (4, 2, 2))
        words.append(alarm.feed(epipolar_residuals(of_pairs, pixels)[:, 0], k * NS_PER_S // FPS))
    assert set(words[: 20 * FPS]) == {None}
    assert words[-1] is not None

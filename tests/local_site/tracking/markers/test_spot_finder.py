"""One camera's spots at an instant between two exposures, and behind a lens that bends."""

import numpy as np
import pytest

from common.cameras.camera import Frame
from local_site.calibration.triangulation import project
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import StereoConfig
from local_site.tracking.markers.spots import SpotFinder, Spots, interpolated
from local_site.tracking.tracker import View
from tests.local_site.tracking.markers.marker_scene import (
    PERIOD_NS,
    draw,
    four_cameras,
    hand_at,
    rig_of,
)


def spots(pixels):
    pixels = np.array(pixels, dtype=float)
    return Spots(pixels, pixels, np.full(len(pixels), 0.1), np.full(len(pixels), 80.0))


def test_spots_are_paired_across_a_step_as_wide_as_their_distance():
    before, step = np.array([[100.0, 100.0], [130.0, 100.0], [115.0, 140.0]]), np.array([29.0, 3.0])
    between = interpolated(spots(before), spots((before + step)[[2, 0, 1]]), 0.25)
    assert between.pixels == pytest.approx(before + 0.25 * step)


def test_a_spot_that_only_one_exposure_shows_is_left_out():
    between = interpolated(spots([[100, 100], [200, 100]]), spots([[104, 100]]), 0.5)
    assert between.pixels == pytest.approx(np.array([[102.0, 100.0]]))
    assert len(interpolated(spots([[100, 100]]), spots([[300, 100]]), 0.5)) == 0


def test_views_are_interpolated_at_their_weight():
    camera = four_cameras()[0]
    start, end = hand_at(), hand_at((0.02, 0.0, 0.01))
    view = View(Frame(draw(camera, end), PERIOD_NS, 1), Frame(draw(camera, start), 0, 0), weight=0.7)
    found = SpotFinder(rig_of([camera, camera]).cameras[0], 40).spots(view)
    assert isinstance(found, Spots)
    expected = 0.3 * camera.pixels(camera.to_camera(start)) + 0.7 * camera.pixels(camera.to_camera(end))
    for pixel in expected:
        assert np.linalg.norm(found.pixels - pixel, axis=1).min() < 0.1


def test_spots_behind_a_bending_lens_are_straightened():
    camera = stereo_pair(StereoConfig(k1=-0.2))[0]
    points = hand_at((0.15, 0.0, 0.1))
    calibration = rig_of([camera, camera]).cameras[0]
    bent = calibration.__class__(calibration.name, calibration.projection, 0.3, camera.physical.lens)
    found = SpotFinder(bent, 40).spots(View(Frame(draw(camera, points), 0, 0)))
    assert isinstance(found, Spots)
    for pixel in project(camera.projection, points):
        assert np.linalg.norm(found.pixels - pixel, axis=1).min() < 0.1
    assert np.linalg.norm(found.in_picture - found.pixels, axis=1).max() > 0.5

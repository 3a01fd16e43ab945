"""The uncertainty of a marker's measurement: honest with a calibration's errors and with a marker shown in part."""

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.simulation.cameras import calibrate_simulated, exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.tracking.markers.correspondence import Candidates
from local_site.tracking.markers.measuring import SAMPLING_SIGMA_PX, MarkerMeter
from local_site.tracking.markers.spots import Spots
from tests.local_site.tracking.markers.marker_scene import (
    START,
    Scene,
    draw,
    hand_at,
    rig_of,
    spots_in,
)

RADIUS_M = 0.011


def spots(pixel):
    return Spots(pixel[None], pixel[None], np.array([0.01]), np.array([80.0]))


def candidate(point):
    return Candidates(point[None], np.zeros((1, 2), dtype=np.int64), np.zeros(1))


@pytest.mark.slow
def test_errors_of_calibrated_cameras_average_what_the_covariance_expects():
    random = np.random.default_rng(8)
    normalised = []
    for seed in range(12):
        config = SimulationConfig(seed=seed)
        meter, exact = MarkerMeter(calibrate_simulated(config)), exact_rig(config.stereo).matrices
        for _ in range(20):
            point = START + random.uniform(-0.2, 0.2, 3)
            pixels = [project(m, point) + SAMPLING_SIGMA_PX * random.standard_normal(2) for m in exact]
            fix = meter.measure(candidate(point), 0, [spots(pixel) for pixel in pixels], None).fix
            normalised.append((fix.point - point) @ np.linalg.solve(fix.covariance, fix.point - point))
    assert 1.5 < np.mean(normalised) < 6.0


def covered(share_px, seed):
    """Error, expected error (mm) and wholeness of a marker of which one view hides all right of `share_px`."""
    scene = Scene()
    camera = scene.cameras[0]
    points = hand_at((0.004 * seed, 0.003 * seed, 0.0))
    pictures = [draw(c, points[1:2], levels=(220.0,), noise=1.5, seed=seed) for c in scene.cameras]
    u, v = camera.pixels(camera.to_camera(points[1])).astype(int)
    pictures[0][v - 12 : v + 12, u + share_px : u + 14] = 10
    found = [spots_in(picture) for picture in pictures]
    sighting = MarkerMeter(rig_of(scene.cameras)).measure(candidate(points[1]), 0, found, 2 * RADIUS_M)
    error = np.linalg.norm(sighting.fix.point - points[1])
    return 1e3 * error, 1e3 * np.sqrt(np.trace(sighting.fix.covariance)), sighting.is_whole


@pytest.mark.parametrize("share_px", [5, 3, 1, -1])
def test_a_marker_shown_in_part_is_as_unsure_as_it_is_wrong(share_px):
    error, expected, _ = np.mean([covered(share_px, seed) for seed in range(5)], axis=0)
    assert 0.5 * expected < error < 2.0 * expected


def test_a_whole_marker_is_whole_and_sure():
    told = [covered(13, seed) for seed in range(5)]
    assert all(whole for _, _, whole in told)
    assert max(expected for _, expected, _ in told) < 0.5
    assert not covered(2, 0)[2]


def test_the_diameter_is_measured_in_metres():
    scene = Scene()
    point = hand_at()[0]
    found = [spots_in(draw(camera, point[None], levels=(220.0,))) for camera in scene.cameras]
    sighting = MarkerMeter(rig_of(scene.cameras)).measure(candidate(point), 0, found, None)
    assert sighting.size == pytest.approx(2 * RADIUS_M, rel=0.04)

"""The simulated cameras: their projections, and control points that lead back to them."""

import csv

import numpy as np
import pytest

from local_site.simulation.cameras import control_point_rows, control_points, exact_rig, stereo_pair
from local_site.simulation.config import StereoConfig


def parsed(rows):
    return list(csv.DictReader(rows))


def test_the_rig_projects_as_the_cameras_do():
    config = StereoConfig()
    points = np.random.default_rng(1).uniform(0.2, 0.8, (20, 3))
    for matrix, camera in zip(exact_rig(config).matrices, stereo_pair(config), strict=True):
        image = np.column_stack([points, np.ones(20)]) @ matrix.T
        assert image[:, :2] / image[:, 2:] == pytest.approx(camera.pixels(camera.to_camera(points)))


def test_cameras_look_at_the_centre_from_both_sides_and_upright():
    config = StereoConfig()
    left, right = stereo_pair(config)
    for camera in (left, right):
        assert camera.pixels(camera.to_camera(np.array(config.centre))) == pytest.approx([319.5, 239.5])
        assert np.linalg.norm(camera.centre - config.centre) == pytest.approx(config.distance_m)
        beside, above = camera.pixels(camera.to_camera(config.centre + 0.1 * np.eye(3)[[0, 2]]))
        assert above[1] < 200
        assert beside[0] > 350
    assert left.centre[0] < config.centre[0] < right.centre[0]


def test_control_points_are_a_plate_at_three_heights():
    points = control_points()
    assert points.shape == (75, 3)
    assert len(np.unique(points, axis=0)) == 75
    assert np.unique(points[:, 2]) == pytest.approx([0.0, 0.497, 0.994])


def test_control_point_rows_fit_the_exact_rig_within_their_noise():
    config = StereoConfig()
    rows = parsed(control_point_rows(config, noise_px=0.3, seed=4))
    assert len(rows) == 75
    for matrix, side in zip(exact_rig(config).matrices, "LR", strict=True):
        seen = [row for row in rows if row[f"u{side}_px"]]
        assert len(seen) >= 30
        points = np.array([[float(row[k]) / 1000 for k in ("X_mm", "Y_mm", "Z_mm")] + [1.0] for row in seen])
        pixels = np.array([[float(row[f"{k}{side}_px"]) for k in "uv"] for row in seen])
        image = points @ matrix.T
        residuals = pixels - image[:, :2] / image[:, 2:]
        assert residuals.std() == pytest.approx(0.3, abs=0.06)


def test_control_points_show_the_distortion_of_the_lens():
    plain, bent = (parsed(control_point_rows(StereoConfig(k1=k1), 0.0, seed=1)) for k1 in (0.0, -0.1))
    moved = [
        float(a["uL_px"]) - float(b["uL_px"]) for a, b in zip(plain, bent, strict=True) if a["uL_px"] and b["uL_px"]
    ]
    assert np.abs(moved).max() > 2.0

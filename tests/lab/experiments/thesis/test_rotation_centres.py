"""Spheres and circles through points, exact where the points are: and what ten frames of an arc cannot tell."""

import numpy as np
import pytest

from common.geometry import rotation_from_vector
from lab.experiments.thesis.icr import across_axis, fit_circle, fit_sphere, windows

CENTRE, RADIUS = np.array([0.5, 0.4, 0.6]), 0.41


def arc(degrees, count, height=0.0):
    """Points on a circle about a tilted axis through CENTRE, `height` above it, and that axis."""
    turn = rotation_from_vector(np.array([0.3, -0.5, 0.2]))
    angles = np.radians(np.linspace(0.0, degrees, count))
    flat = np.column_stack([RADIUS * np.cos(angles), RADIUS * np.sin(angles), np.full(count, height)])
    return CENTRE + flat @ turn.T, turn[:, 2]


def test_windows_are_all_runs_of_frames():
    rows = np.arange(150.0).reshape(75, 2)
    runs = windows(rows, 10)
    assert runs.shape == (66, 10, 2)
    assert np.array_equal(runs[65], rows[65:])


def test_a_sphere_is_found_exactly():
    directions = np.random.default_rng(3).standard_normal((12, 3))
    points = CENTRE + RADIUS * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    centre, radius = fit_sphere(points)
    assert centre == pytest.approx(CENTRE, abs=1e-12)
    assert radius == pytest.approx(RADIUS, abs=1e-12)


@pytest.mark.parametrize(("degrees", "count"), [(11.0, 10), (90.0, 75)])
def test_a_circle_is_found_exactly_and_its_centre_is_at_the_height_of_the_points(degrees, count):
    points, axis = arc(degrees, count, height=0.025)
    circle = fit_circle(points)
    assert circle.centre == pytest.approx(CENTRE + 0.025 * axis, abs=1e-9)
    assert abs(circle.axis @ axis) == pytest.approx(1.0)
    assert circle.radius == pytest.approx(RADIUS, abs=1e-9)
    assert across_axis((circle.centre - CENTRE)[None], circle.axis) == pytest.approx(np.zeros((1, 3)), abs=1e-9)


def test_a_sphere_of_exact_points_of_one_plane_has_its_centre_there():
    points, _ = arc(90.0, 75)
    assert fit_sphere(points)[0] == pytest.approx(CENTRE, abs=1e-9)


def test_noise_of_a_tenth_of_a_millimetre_moves_the_sphere_of_ten_frames_by_centimetres_and_the_whole_circle_hardly():
    points, _ = arc(90.0, 75)
    noisy = points + 1e-4 * np.random.default_rng(5).standard_normal(points.shape)
    spheres = np.array([fit_sphere(ten)[0] for ten in windows(noisy, 10)])
    assert np.median(np.linalg.norm(spheres - CENTRE, axis=1)) > 0.03
    assert np.linalg.norm(fit_circle(noisy).centre - CENTRE) < 0.0003

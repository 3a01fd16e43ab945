"""A marker's covariance is honest: errors normalised by it average the number of their dimensions."""

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.tracking.markers.measuring import fix_marker, magnifications
from tests.local_site.tracking.markers.marker_scene import START, four_cameras

PROJECTIONS = np.array([camera.projection for camera in four_cameras()])


def drawn(views, sigmas, count=500, seed=2):
    """Fixes of random points from noisy pixels, with their errors (N, 3)."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        point = START + random.uniform(-0.2, 0.2, 3)
        pixels = np.array([project(m, point) for m in PROJECTIONS[views]])
        noisy = pixels + np.asarray(sigmas)[:, None] * random.standard_normal(pixels.shape)
        fix = fix_marker(PROJECTIONS[views], noisy, np.asarray(sigmas), point + random.uniform(-0.02, 0.02, 3))
        yield fix, fix.point - point


@pytest.mark.parametrize(
    ("views", "sigmas"), [([0, 1], [0.1, 0.1]), ([0, 2, 3], [0.1, 0.4, 0.2]), ([0, 1, 2, 3], [0.1, 0.1, 1.0, 0.3])]
)
def test_normalised_errors_average_three(views, sigmas):
    found = list(drawn(views, sigmas))
    unscaled = [fix.covariance / max(1.0, fix.misfit / fix.freedom) for fix, _ in found]
    nees = [error @ np.linalg.solve(cov, error) for (_, error), cov in zip(found, unscaled, strict=True)]
    assert np.mean(nees) == pytest.approx(3.0, rel=0.12)
    assert np.mean([fix.misfit for fix, _ in found]) == pytest.approx(found[0][0].freedom, rel=0.25)


def test_views_that_disagree_never_make_it_surer():
    point = START
    pixels = np.array([project(m, point) for m in PROJECTIONS])
    sure = fix_marker(PROJECTIONS, pixels, np.full(4, 0.1), point)
    apart = fix_marker(PROJECTIONS, pixels + np.array([[0, 0], [0, 3.0], [0, 0], [0, 0]]), np.full(4, 0.1), point)
    assert np.trace(apart.covariance) > 10 * np.trace(sure.covariance)


def test_depth_is_less_sure_than_what_lies_across_the_view():
    fix = fix_marker(PROJECTIONS[:2], np.array([project(m, START) for m in PROJECTIONS[:2]]), np.full(2, 0.1), START)
    assert fix.covariance[1, 1] > 2 * fix.covariance[2, 2]


def test_magnification_is_the_length_of_a_metre_in_the_picture():
    for matrix, camera in zip(PROJECTIONS, four_cameras(), strict=True):
        right = camera.camera_R_operator[0]
        length = np.linalg.norm(project(matrix, START + 0.005 * right) - project(matrix, START - 0.005 * right)) / 0.01
        assert magnifications(matrix[None], START)[0] == pytest.approx(length, rel=0.03)

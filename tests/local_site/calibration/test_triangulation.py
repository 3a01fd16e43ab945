"""Triangulation: points seen by two or more cameras are recovered, one by one and all together."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from local_site.calibration.triangulation import (
    epipolar_residuals,
    fundamental_matrix,
    fundamentals,
    project,
    reprojection_residual,
    triangulate,
    triangulate_many,
)
from tests.local_site.calibration.plate_cameras import ANGLES, camera

K = np.array([[900.0, 0.0, 320.0], [0.0, 900.0, 240.0], [0.0, 0.0, 1.0]])


def looking(turn, shift):
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return K @ np.column_stack([rotation, [shift, 0.1 * shift, 2.0]])


CAMERAS = [looking(-0.4, 0.1), looking(0.4, -0.1), looking(0.0, 0.3)]
coordinate = st.floats(-0.5, 0.5)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.tuples(coordinate, coordinate, coordinate), st.integers(2, 3))
def test_points_survive_projection_and_triangulation(point, count):
    point = np.array(point)
    pixels = [project(m, point) for m in CAMERAS[:count]]
    found = triangulate(CAMERAS[:count], pixels)
    assert np.allclose(found, point, atol=1e-8)
    assert reprojection_residual(CAMERAS[:count], pixels, found) < 1e-6
    assert np.allclose(triangulate_many(CAMERAS[:count], np.array([pixels, pixels]))[1], point, atol=1e-7)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.tuples(coordinate, coordinate, coordinate), st.floats(2, 30))
def test_epipolar_residual_is_zero_for_true_pairs_and_grows_off_the_line(point, off):
    fundamental = fundamental_matrix(CAMERAS[0], CAMERAS[1])
    of_pairs = fundamentals(CAMERAS[:2])
    a, b = (project(m, np.array(point)) for m in CAMERAS[:2])
    assert epipolar_residuals(of_pairs, np.array([[a, b]]))[0, 0] < 1e-6
    normal = (fundamental @ np.append(a, 1.0))[:2]
    moved = b + off * normal / np.linalg.norm(normal)
    assert 0.4 * off < epipolar_residuals(of_pairs, np.array([[a, moved]]))[0, 0] <= off


def test_epipolar_residuals_are_sampson_distances_of_every_pair():
    cameras = [camera(angle) for angle in (*ANGLES, 0.0)]
    random = np.random.default_rng(5)
    pixels = np.stack([c.pixels(random.uniform(0.3, 0.7, (5, 3))) for c in cameras], axis=1) + 3.0
    pixels[0, 2] = np.nan
    of_pairs = fundamentals([c.projection for c in cameras])
    found = epipolar_residuals(of_pairs, pixels)
    assert found.shape == (5, 3)
    assert np.isnan(found[0]).tolist() == [False, True, True]
    for column, ((i, j), fundamental) in enumerate(of_pairs.items()):
        first, second = (np.append(pixels[1, k], 1.0) for k in (i, j))
        assert found[1, column] == pytest.approx(np.sqrt(cv2.sampsonDistance(first, second, fundamental)))

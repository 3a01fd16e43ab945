"""Triangulation: what two or more cameras see comes back, one by one and all at once."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from local_site.calibration.triangulation import (
    epipolar_residual,
    fundamental_matrix,
    project,
    reprojection_residual,
    triangulate,
    triangulate_many,
)

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
    a, b = (project(m, np.array(point)) for m in CAMERAS[:2])
    assert epipolar_residual(fundamental, a, b) < 1e-6
    normal = (fundamental @ np.append(a, 1.0))[:2]
    moved = b + off * normal / np.linalg.norm(normal)
    assert 0.4 * off < epipolar_residual(fundamental, a, moved) <= off

"""Direct linear transformation: exact points give the exact cameras, and bad points are refused by line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.errors import CalibrationError
from farhand.calibrate import calibrate_points
from local_site.calibration.control_points import ControlPoints
from local_site.calibration.dlt import solve_projection, solve_rig
from local_site.calibration.rig import load_rig
from local_site.calibration.triangulation import project, triangulate

DATA = Path(__file__).parents[4] / "shared/data/recordings"
GRID = np.array([[x, y, z] for z in (0.0, 0.5, 1.0) for y in (0.0, 0.5, 1.0) for x in (0.0, 0.25, 0.5, 0.75, 1.0)])


def camera(angle_deg, focal=800.0, distance=2.0):
    """A pinhole camera (3, 4) that looks at the middle of the grid."""
    angle = np.radians(angle_deg)
    forward = np.array([np.sin(angle), np.cos(angle), -0.2])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.array([right, np.cross(forward, right), forward])
    centre = np.array([0.5, 0.5, 0.5]) - distance * forward
    intrinsic = np.array([[focal, 0.0, 320.0], [0.0, focal, 240.0], [0.0, 0.0, 1.0]])
    return intrinsic @ np.column_stack([rotation, -rotation @ centre])


def control(points=GRID, angles=(-25.0, 25.0), noise=0.0, seed=0):
    random = np.random.default_rng(seed)
    pixels = tuple(project(camera(a), points) + noise * random.standard_normal((len(points), 2)) for a in angles)
    return ControlPoints(points, pixels, tuple(range(2, len(points) + 2)), "points.csv")


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.floats(-60, 60), st.floats(400, 2000), st.floats(1.6, 5.0))
def test_exact_points_give_back_the_camera(angle, focal, distance):
    truth = camera(angle, focal, distance)
    solved = solve_projection(GRID, project(truth, GRID))
    assert np.allclose(solved, truth, rtol=1e-6, atol=1e-5)


def test_refinement_leaves_residuals_of_the_size_of_the_noise():
    rig = solve_rig(control(noise=0.3), "now")
    assert all(0.3 < c.reprojection_rms_px < 0.3 * 1.6 for c in rig.cameras)
    assert all(error < 0.0015 for error in rig.error_rms)
    assert rig.volume_min == (0.0, 0.0, 0.0)
    assert rig.volume_max == (1.0, 1.0, 1.0)


@pytest.mark.parametrize("angle", [-60.0, 0.0, 25.0])
def test_the_rig_triangulates_what_it_sees(angle):
    matrices = solve_rig(control(), "now").matrices
    point = np.array([0.4, 0.3 + angle / 1000, 0.6])
    assert np.allclose(triangulate(matrices, [project(m, point) for m in matrices]), point, atol=1e-6)


def test_one_plane_and_too_few_points_are_refused_for_each_camera():
    flat = GRID[GRID[:, 2] == 0.0]
    with pytest.raises(CalibrationError, match=r"left camera.*one plane[\s\S]*right camera.*one plane"):
        solve_rig(control(flat), "now")
    with pytest.raises(CalibrationError, match="sees 5 control points, needs at least 6"):
        solve_rig(control(GRID[[0, 7, 20, 33, 44]]), "now")


@pytest.mark.parametrize("noise", [0.0, 0.4])
def test_gross_outliers_are_named_with_their_lines(noise):
    points = control(noise=noise)
    points.pixels[0][3] += (60.0, -20.0)
    points.pixels[1][17] += (0.0, 25.0)
    with pytest.raises(CalibrationError) as caught:
        solve_rig(points, "now")
    text = str(caught.value)
    assert "line 5:" in text
    assert "line 19:" in text
    assert text.count("line ") == 2
    assert "measure this point again" in text


def test_cameras_without_a_common_point_are_refused():
    points = control()
    points.pixels[0][::2] = np.nan
    points.pixels[1][1::2] = np.nan
    with pytest.raises(CalibrationError, match="overlap"):
        solve_rig(points, "now")


@pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")
def test_the_recorded_plate_gives_a_rig_within_a_millimetre_and_a_half(tmp_path):
    out = tmp_path / "rig.json"
    rig = calibrate_points(DATA / "yz" / "control_points.csv", out)
    assert load_rig(out) == rig
    assert all(camera.reprojection_rms_px < 0.5 for camera in rig.cameras)
    assert all(error < 0.0015 for error in rig.error_rms)

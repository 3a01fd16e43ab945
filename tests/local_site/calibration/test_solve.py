"""A rig from control points: exact where they are, honest about noise, every bad input refused with a cure."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from common.errors import CalibrationError
from local_site.calibration.accuracy import errors
from local_site.calibration.control_points import ControlPoints, read_control_points
from local_site.calibration.solve import solve_rig
from local_site.calibration.triangulation import triangulate
from local_site.simulation.cameras import calibrate_simulated, stereo_pair
from local_site.simulation.config import SimulationConfig, StereoConfig
from tests.local_site.calibration.plate_cameras import (
    ANGLES,
    GRID,
    camera,
    control,
)
from tests.present import present

DATA = Path(__file__).parents[4] / "shared/data/recordings"
INSIDE = np.random.default_rng(7).uniform(0.1, 0.9, (40, 3))


def worst_mm(rig, cameras, points=INSIDE):
    """The largest distance between points and what the rig makes of their pixels, mm."""
    distances = []
    for point in points:
        pixels = [c.pixels(point) for c in cameras]
        straight = [
            p if k.lens is None else k.lens.undistort_pixels(p) for k, p in zip(rig.cameras, pixels, strict=True)
        ]
        distances.append(np.linalg.norm(triangulate(rig.matrices, straight) - point))
    return 1e3 * max(distances)


@pytest.mark.slow
@pytest.mark.parametrize("k", [(0.0, 0.0), (-0.1, 0.0), (-0.1, 0.03), (-0.3, 0.1), (0.15, 0.0)])
@pytest.mark.parametrize("aspect", [1.0, 1.02])
def test_exact_points_are_given_back_to_a_twentieth_of_a_millimetre(k, aspect):
    cameras = [camera(angle, k1=k[0], k2=k[1], aspect=aspect) for angle in ANGLES]
    rig = solve_rig(control(cameras), "now")
    assert worst_mm(rig, cameras) < 0.05
    assert max(rig.error_rms) < 5e-5
    assert max(present(rig.leave_one_out_rms)) < 5e-5
    for found in rig.cameras:
        assert (found.lens is None) == (k == (0.0, 0.0))
        if found.lens is not None:
            assert (found.lens.k1, found.lens.k2) == pytest.approx(k, abs=1e-4)


def test_points_written_with_three_decimals_are_exact_enough():
    cameras = [camera(angle, k1=-0.1) for angle in ANGLES]
    exact = control(cameras)
    rig = solve_rig(replace(exact, pixels=tuple(np.round(p, 3) for p in exact.pixels)), "now")
    assert worst_mm(rig, cameras) < 0.05


def test_three_and_four_cameras_are_solved_alike():
    cameras = [camera(angle, k1=-0.05) for angle in (*ANGLES, 0.0, 50.0)]
    rig = solve_rig(control(cameras), "now")
    assert [c.name for c in rig.cameras] == ["left", "right", "third", "fourth"]
    assert worst_mm(rig, cameras) < 0.05


def test_noise_is_not_taken_for_distortion():
    rigs = [solve_rig(control(noise=0.3, seed=seed), "now") for seed in range(6)]
    assert sum(c.lens is None for rig in rigs for c in rig.cameras) >= 11
    assert "F-test at 1 %: k2 p = " in rigs[0].lens_choice[0]


def test_distortion_is_found_under_noise():
    cameras = [camera(angle, k1=-0.1) for angle in ANGLES]
    rig = solve_rig(control(cameras, noise=0.3), "now")
    assert [present(c.lens).k1 for c in rig.cameras] == pytest.approx([-0.1, -0.1], abs=0.03)
    assert worst_mm(rig, cameras) < 1.5


def test_residuals_are_of_the_size_of_the_noise_and_leaving_out_makes_them_larger():
    rig = solve_rig(control(noise=0.3), "now")
    assert [c.reprojection_rms_px for c in rig.cameras] == pytest.approx([0.41, 0.41], abs=0.05)
    assert max(rig.error_rms) < 0.0015
    assert all(left > kept for left, kept in zip(present(rig.leave_one_out_rms), rig.error_rms, strict=True))
    assert 0.1 < present(rig.epipolar_px) < 0.4
    assert rig.volume_min == (0.0, 0.0, 0.0)
    assert rig.volume_max == (1.0, 1.0, 1.0)


def test_leaving_out_is_what_a_rig_without_the_point_gives():
    points = control(noise=0.3)
    rig_errors = []
    for i in range(0, 75, 25):
        others = np.arange(75) != i
        rest = ControlPoints(
            points.points[others], tuple(p[others] for p in points.pixels), points.labels[1:], points.source
        )
        rig = solve_rig(rest, "now")
        pixels = [p[i] for p in points.pixels]
        rig_errors.append(triangulate(rig.matrices, pixels) - points.points[i])
    from local_site.calibration import accuracy, solve

    solved = [solve._solve_camera(name, points, p) for name, p in zip(points.cameras, points.pixels, strict=True)]
    resections = [resection for resection, _ in solved if not isinstance(resection, str)]
    quick = accuracy.leave_one_out_errors(resections, points.points, points.pixels)
    assert quick[::25] == pytest.approx(np.array(rig_errors), abs=2e-5)


def test_one_plane_and_too_few_points_are_refused_for_each_camera():
    with pytest.raises(CalibrationError, match=r"left camera.*one plane[\s\S]*right camera.*one plane"):
        solve_rig(control(points=GRID[GRID[:, 2] == 0.0]), "now")
    with pytest.raises(CalibrationError, match="sees 5 control points, needs at least 6; show it more"):
        solve_rig(control(points=GRID[[0, 7, 20, 33, 44]]), "now")


def test_six_points_are_enough_where_they_are_exact():
    cameras = [camera(angle) for angle in ANGLES]
    rig = solve_rig(control(cameras, points=GRID[[0, 4, 22, 33, 50, 74]]), "now")
    assert worst_mm(rig, cameras) < 0.05


@pytest.mark.parametrize("noise", [0.0, 0.4])
@pytest.mark.parametrize("k1", [0.0, -0.3])
def test_gross_outliers_are_named_with_their_lines(noise, k1):
    points = control([camera(angle, k1=k1) for angle in ANGLES], noise=noise)
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


def test_exchanged_cameras_are_refused():
    points = control(noise=0.3)
    with pytest.raises(CalibrationError, match="exchange the two"):
        solve_rig(replace(points, pixels=points.pixels[::-1]), "now")


def test_one_camera_given_twice_is_refused():
    points = control(noise=0.3)
    with pytest.raises(CalibrationError, match="move the cameras apart"):
        solve_rig(replace(points, pixels=(points.pixels[0], points.pixels[0].copy())), "now")


@pytest.mark.parametrize("which", [0, 1])
def test_a_mirrored_picture_is_refused(which):
    points = control(noise=0.3)
    points.pixels[which][:, 0] = 639 - points.pixels[which][:, 0]
    with pytest.raises(CalibrationError, match=f"{points.cameras[which]} camera: sees the points mirrored; switch off"):
        solve_rig(points, "now")


def test_left_handed_control_points_are_refused():
    points = control(noise=0.3)
    with pytest.raises(CalibrationError, match="correct the axes"):
        solve_rig(replace(points, points=points.points[:, [1, 0, 2]]), "now")


@pytest.mark.parametrize("seed", range(4))
def test_pixels_without_sense_are_refused(seed):
    random = np.random.default_rng(seed)
    pixels = tuple(random.uniform(0, 640, (75, 2)) for _ in range(2))
    with pytest.raises(CalibrationError, match=r"left camera.*; [\s\S]*right camera"):
        solve_rig(replace(control(), pixels=pixels), "now")


@pytest.mark.parametrize("pixel", [0.0, 320.0, 1e9])
def test_one_pixel_for_all_points_is_refused(pixel):
    pixels = (np.full((75, 2), pixel), control().pixels[1])
    with pytest.raises(CalibrationError, match="left camera"):
        solve_rig(replace(control(), pixels=pixels), "now")


@pytest.mark.parametrize("k1", [0.0, -0.1])
def test_the_simulated_pair_is_calibrated_with_its_lens(k1):
    stereo = StereoConfig(k1=k1)
    rig = calibrate_simulated(SimulationConfig(stereo=stereo))
    assert all((c.lens is None) == (k1 == 0.0) for c in rig.cameras)
    points = np.random.default_rng(3).uniform(0.3, 0.7, (30, 3))
    truth = stereo_pair(stereo)
    for point in points:
        pixels = [c.pixels(c.to_camera(point)) for c in truth]
        straight = [
            p if c.lens is None else c.lens.undistort_pixels(p) for c, p in zip(rig.cameras, pixels, strict=True)
        ]
        assert triangulate(rig.matrices, straight) == pytest.approx(point, abs=0.0015)


@pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")
@pytest.mark.parametrize("recording", ["yz", "toggle", "icr_elbow", "pick"])
def test_the_recorded_plate_gives_its_points_back(recording):
    control_points = read_control_points(DATA / recording / "control_points.csv")
    rig = solve_rig(control_points, "now")
    assert all(c.reprojection_rms_px < 0.45 for c in rig.cameras)
    assert np.linalg.norm(rig.error_rms) < 0.0016
    assert np.linalg.norm(present(rig.leave_one_out_rms)) < 0.0018
    assert all(c.lens is None for c in rig.cameras)


def test_errors_are_nan_where_only_one_camera_sees_a_point():
    points = control()
    points.pixels[0][5] = np.nan
    found = errors([camera(angle) for angle in ANGLES], points.points, points.pixels)
    assert np.isnan(found[5]).all()
    assert np.abs(np.delete(found, 5, axis=0)).max() < 1e-9

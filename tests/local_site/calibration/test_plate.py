"""The plate of discs: found and ordered without help, whole or cropped, and centred without perspective bias."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from common.cameras.camera import Image
from common.errors import CalibrationError
from local_site.calibration.control_points import read_control_points
from local_site.calibration.lattice import find_discs, find_lattice
from local_site.calibration.plate import Plate, plate_control_points, view_plate, without_perspective_bias
from local_site.calibration.solve import solve_rig
from local_site.calibration.triangulation import triangulate
from local_site.simulation.calibration_scenes.plate_scene import plate_picture
from tests.local_site.calibration.plate_cameras import ANGLES, camera
from tests.present import present

DATA = Path(__file__).parents[4] / "shared/data/recordings"
HEIGHTS = (0.0, 0.497, 0.994)
PLATE = Plate()
RECORDED = pytest.mark.skipif(not DATA.exists(), reason="the recordings are not here")


def picture_of(side: str, k: int) -> Image:
    return np.asarray(present(cv2.imread(str(DATA / f"calib_{side}_{k}.png"))), np.uint8)


def recorded():
    views = [[view_plate(picture_of(side, k), PLATE, side) for k in range(3)] for side in ("left", "right")]
    return plate_control_points(views, HEIGHTS, PLATE)


def simulated(k1=0.0, plate=PLATE, **places):
    cameras = [camera(angle, k1=k1, drop=0.7, **places) for angle in ANGLES]
    views = [
        [view_plate(plate_picture(plate, c, h, seed=k), plate, "view") for k, h in enumerate(HEIGHTS)] for c in cameras
    ]
    return cameras, plate_control_points(views, HEIGHTS, plate)


@RECORDED
def test_recorded_discs_are_found_and_ordered():
    found, listed = recorded(), read_control_points(DATA / "yz" / "control_points.csv")
    assert found.points == pytest.approx(listed.points, abs=1e-9)
    for ours, theirs in zip(found.pixels, listed.pixels, strict=True):
        # A disc that the border cuts is not measured, though its centre is listed.
        assert np.isfinite(ours[:, 0]).sum() >= np.isfinite(theirs[:, 0]).sum() - 1
        assert not np.any(np.isfinite(ours[:, 0]) & np.isnan(theirs[:, 0]))
        off = (ours - theirs)[np.isfinite(ours[:, 0])]
        assert np.abs(off.mean(axis=0)).max() < 0.1
        assert np.sqrt(np.mean(off**2)) < 0.33
        assert np.linalg.norm(off, axis=1).max() < 1.0


@RECORDED
def test_recorded_discs_give_a_rig_to_a_fifth_of_a_millimetre():
    control = recorded()
    rig = solve_rig(without_perspective_bias(control, solve_rig(control, "").matrices, PLATE.diameter), "now")
    assert all(c.reprojection_rms_px < 0.05 for c in rig.cameras)
    assert np.linalg.norm(present(rig.leave_one_out_rms)) < 0.0002
    assert all(c.lens is None for c in rig.cameras)


@pytest.mark.slow
@pytest.mark.parametrize("k1", [0.0, -0.1])
def test_discs_give_back_the_cameras(k1):
    cameras, control = simulated(k1)
    rig = solve_rig(control, "")
    rig = solve_rig(without_perspective_bias(control, rig.matrices, PLATE.diameter), "now")
    assert all((c.lens is None) == (k1 == 0.0) for c in rig.cameras)
    for point in np.random.default_rng(2).uniform(0.2, 0.8, (20, 3)):
        straight = [
            c.pixels(point) if k.lens is None else k.lens.undistort_pixels(c.pixels(point))
            for c, k in zip(cameras, rig.cameras, strict=True)
        ]
        assert triangulate(rig.matrices, straight) == pytest.approx(point, abs=0.0003)


def test_cropped_plates_are_placed_by_their_ends_and_their_heights():
    cameras, control = simulated(distance=1.6)
    counts = [np.isfinite(pixels[:, 0]).sum() for pixels in control.pixels]
    assert max(counts) < 70
    for c, pixels in zip(cameras, control.pixels, strict=True):
        seen = np.isfinite(pixels[:, 0])
        assert pixels[seen] == pytest.approx(c.pixels(control.points[seen]), abs=0.4)


def test_other_heights_tell_where_a_plate_without_an_end_in_view_lies():
    cameras = [camera(angle, drop=0.7) for angle in ANGLES]
    views = [[view_plate(plate_picture(PLATE, c, h), PLATE, "view") for h in HEIGHTS] for c in cameras]
    seen = views[0][1]
    inner = seen.lattice.cells[:, 0] >= 1
    lattice = replace(seen.lattice, cells=seen.lattice.cells[inner] - (1, 0), pixels=seen.lattice.pixels[inner])
    views[0][1] = replace(seen, lattice=lattice, beginnings=((0, 0), (1, 0)))
    control = plate_control_points(views, HEIGHTS, PLATE)
    found = np.isfinite(control.pixels[0][:, 0])
    assert control.pixels[0][found] == pytest.approx(cameras[0].pixels(control.points[found]), abs=0.4)


def test_large_discs_lose_their_perspective_bias():
    plate = Plate(diameter=0.12)
    cameras, control = simulated(plate=plate)
    exact = [c.pixels(control.points) for c in cameras]
    straight = without_perspective_bias(control, [c.projection for c in cameras], plate.diameter)

    def bias(points):
        return [float(np.linalg.norm(np.nanmean(p - e, axis=0))) for p, e in zip(points.pixels, exact, strict=True)]

    assert min(bias(control)) > 0.1
    assert max(bias(straight)) < 0.03


def test_oblong_plates_are_ordered_by_their_shape():
    plate = Plate(columns=6, rows=4, pitch=0.16, diameter=0.03)
    for angle in (-20.0, 0.0, 35.0):
        c = camera(angle, drop=1.0, distance=2.2)
        view = view_plate(plate_picture(plate, c, 0.5), plate, "view")
        assert view.lattice.extent == (6, 4)
        points = np.column_stack([view.lattice.cells * plate.pitch, np.full(24, 0.5)])
        assert view.lattice.pixels == pytest.approx(c.pixels(points), abs=0.3)


def test_reflections_do_not_disturb_the_order():
    c = camera(0.0, drop=1.0, distance=2.2)
    picture = plate_picture(PLATE, c, 0.5)
    for centre in ((40, 40), (600, 200), (352, 228)):
        cv2.circle(picture, centre, 4, 220, -1, cv2.LINE_AA)
    view = view_plate(picture, PLATE, "lit")
    assert len(view.lattice.cells) == 25
    points = np.column_stack([view.lattice.cells * PLATE.pitch, np.full(25, 0.5)])
    assert view.lattice.pixels == pytest.approx(c.pixels(points), abs=0.3)


@pytest.mark.parametrize(
    "picture",
    [
        np.zeros((480, 640), np.uint8),
        np.full((480, 640), 255, np.uint8),
        np.random.default_rng(0).integers(0, 256, (480, 640, 3), dtype=np.uint8),
        np.random.default_rng(0).integers(0, 12, (480, 640), dtype=np.uint8),
        np.zeros((3, 5), np.uint8),
    ],
    ids=["black", "white", "random", "dark noise", "tiny"],
)
def test_pictures_without_a_plate_are_refused_with_a_cure(picture):
    with pytest.raises(CalibrationError, match=r"left picture 1: \d+ discs found.*light the plate evenly"):
        view_plate(picture, PLATE, "left picture 1")


def test_a_wrong_count_of_discs_is_refused():
    picture = plate_picture(PLATE, camera(0.0, drop=1.0, distance=2.4), 0.5)
    with pytest.raises(CalibrationError, match=r"ends after 5 x 5 discs, not 7 x 7.*--discs"):
        view_plate(picture, Plate(columns=7, rows=7), "left")
    with pytest.raises(CalibrationError, match="no lattice of 3 x 3"):
        view_plate(picture, Plate(columns=3, rows=3), "left")


def test_a_plate_without_any_end_in_view_is_refused():
    plate = Plate(columns=11, rows=11)
    c = camera(0.0, drop=1.0, distance=1.5)
    inner = [view_plate(plate_picture(plate, c, h), plate, "left") for h in (-0.7, -0.35, 0.0)]
    middle = [replace_beginnings(view) for view in inner]
    with pytest.raises(CalibrationError, match="do not determine which of the plate's discs"):
        plate_control_points([middle, middle], (-0.7, -0.35, 0.0), plate)


def replace_beginnings(view):
    """The view as if none of the plate's ends were seen in it."""
    columns, rows = view.lattice.extent
    return replace(view, beginnings=tuple((i, j) for i in range(12 - columns) for j in range(12 - rows)))


def test_a_handful_of_blobs_is_no_lattice():
    picture = np.zeros((480, 640), np.uint8)
    for k in range(5):
        cv2.circle(picture, (100 + 60 * k, 100), 6, 255, -1, cv2.LINE_AA)
    discs = find_discs(picture)
    assert len(discs) == 5
    assert find_lattice(discs, (5, 5)) is None

"""A lens: distortion and undistortion are inverse, agree with OpenCV, and a picture is undistorted."""

import cv2
import numpy as np
import pytest

from local_site.calibration.physical_camera import Lens
from local_site.calibration.undistortion import TakenPicture, Undistorter

BENT = Lens(fx=800.0, fy=790.0, cx=310.0, cy=245.0, k1=-0.1, k2=0.02)
PIXELS = np.array([(u, v) for u in (0.0, 100.0, 310.0, 639.0) for v in (0.0, 245.0, 479.0)])


@pytest.mark.parametrize("k", [(0.0, 0.0), (-0.1, 0.0), (-0.3, 0.1), (0.2, -0.05)])
def test_straightening_undoes_bending(k):
    lens = Lens(800.0, 790.0, 310.0, 245.0, *k)
    assert lens.undistort_pixels(lens.distort_pixels(PIXELS)) == pytest.approx(PIXELS, abs=1e-9)
    assert np.isnan(lens.undistort_pixels(np.array([np.nan, np.nan]))).all()


def test_bending_is_opencvs():
    slopes = np.column_stack([(PIXELS - (BENT.cx, BENT.cy)) / (BENT.fx, BENT.fy), np.ones(len(PIXELS))])
    expected = cv2.projectPoints(slopes, np.zeros(3), np.zeros(3), BENT.matrix, np.array([BENT.k1, BENT.k2, 0, 0]))[0]
    assert BENT.distort_pixels(PIXELS) == pytest.approx(expected[:, 0], abs=1e-9)


def test_undistortion_puts_every_dot_where_a_pinhole_sees_it():
    picture = np.zeros((480, 640), dtype=np.uint8)
    straight = np.array([(60.0, 60.0), (320.0, 240.0), (590.0, 430.0)])
    for u, v in BENT.distort_pixels(straight):
        cv2.circle(picture, (round(16 * u), round(16 * v)), 16 * 6, 255, -1, cv2.LINE_AA, 4)
    found = Undistorter(BENT, cv2.BORDER_CONSTANT).undistorted(picture)
    for u, v in straight.astype(int):
        moments = cv2.moments(found[v - 15 : v + 16, u - 15 : u + 16])
        assert moments["m10"] / moments["m00"] == pytest.approx(15, abs=0.15)
        assert moments["m01"] / moments["m00"] == pytest.approx(15, abs=0.15)


def test_a_lens_that_folds_the_picture_is_known():
    assert Lens(800.0, 800.0, 320.0, 240.0, k1=-1.0).folds_within(0.6)
    assert not BENT.folds_within(0.6)


@pytest.mark.parametrize("shape", [(480, 640), (480, 640, 3)])
def test_the_maps_are_computed_once_for_each_size(monkeypatch, shape):
    made, make = [], cv2.initUndistortRectifyMap
    monkeypatch.setattr(cv2, "initUndistortRectifyMap", lambda *a: made.append(a) or make(*a))
    undistorter = Undistorter(BENT, cv2.BORDER_CONSTANT)
    for _ in range(3):
        undistorter.undistorted(np.zeros(shape, np.uint8))
    undistorter.undistorted(np.zeros((240, *shape[1:]), np.uint8))
    assert len(made) == 2


def coloured():
    ramp = np.add.outer(np.arange(480) // 4, np.arange(640) // 8).astype(np.uint8)
    return np.dstack([ramp, ramp[::-1], 255 - ramp])


@pytest.mark.parametrize("lens", [None, BENT])
def test_a_part_is_that_of_the_whole_undistorted_picture(lens):
    undistorter = Undistorter(lens, cv2.BORDER_REPLICATE)
    taken = TakenPicture(coloured(), undistorter)
    whole = undistorter.undistorted(coloured())
    assert taken.shape == (480, 640)
    np.testing.assert_array_equal(taken.part(), whole)
    np.testing.assert_array_equal(taken.part(slice(100, 180), slice(250, 640)), whole[100:180, 250:])


@pytest.mark.parametrize("lens", [None, BENT])
def test_single_pixels_are_those_next_to_the_undistorted_ones(lens):
    undistorter = Undistorter(lens, cv2.BORDER_REPLICATE)
    whole = undistorter.undistorted(coloured())
    pixels = np.array([(0, 0), (639, 479), (320, 240), (37, 401)], np.int32)
    found = TakenPicture(coloured(), undistorter).at(pixels)
    assert np.abs(found.astype(int) - whole[pixels[:, 1], pixels[:, 0]]).max() <= 2

"""The palm detector's outputs are read as palms in px of the picture: anchors, letterbox, overlaps, scores."""

import math

import numpy as np
import pytest

from local_site.tracking.landmarks.palm_detector import HAND_SCALE, HAND_SHIFT, PalmDetector, anchors
from tests.local_site.tracking.landmarks.fake_networks import DETECTOR_SIDE, FakeNetwork, palm_outputs

BOX_PX = 40.0
SURE = 3.0
LANDSCAPE, PORTRAIT, SQUARE = (480, 640, 3), (640, 480, 3), (300, 300, 3)


def box(shift=(0.0, 0.0), side=BOX_PX, up=(0.0, -20.0)):
    """A palm's box and points (18,), shifted from the anchor, with the fingers towards `up`."""
    at, up = np.array(shift), np.array(up)
    points = [at, (side, side), at - up, at, at + up, at, at, at, at]
    return np.ravel(points)


def found(palms, shape=LANDSCAPE):
    network = FakeNetwork(DETECTOR_SIDE, lambda _: palm_outputs(palms))
    return PalmDetector(network).find(np.full(shape, 100, np.uint8)), network


def test_anchors_are_the_middles_of_two_grids():
    grid = anchors()
    assert grid.shape == (2016, 2)
    np.testing.assert_allclose(grid[:2], 2 * [[0.5 / 24, 0.5 / 24]])
    np.testing.assert_allclose(grid[2], [1.5 / 24, 0.5 / 24])
    np.testing.assert_allclose(grid[1151], [23.5 / 24, 23.5 / 24])
    np.testing.assert_allclose(grid[1152:1158], 6 * [[0.5 / 12, 0.5 / 12]])
    np.testing.assert_allclose(grid[-1], [11.5 / 12, 11.5 / 12])


@pytest.mark.parametrize("shape", [LANDSCAPE, PORTRAIT, SQUARE])
@pytest.mark.parametrize("anchor", [0, 600, 1151, 1500])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (6.0, -9.0)])
def test_a_palm_is_where_its_anchor_and_its_shift_say(shape, anchor, shift):
    (palm,), _ = found([(anchor, SURE, box(shift))], shape)
    side = max(shape[:2])
    margin = (np.array([shape[1], shape[0]]) - side) / 2
    at = side * (anchors()[anchor] + np.array(shift) / DETECTOR_SIDE) + margin
    box_px = side * BOX_PX / DETECTOR_SIDE
    np.testing.assert_allclose(palm.crop.centre, at - [0.0, HAND_SHIFT * box_px], atol=1e-3)
    assert palm.crop.side_px == pytest.approx(HAND_SCALE * box_px, rel=1e-5)
    assert palm.crop.angle == pytest.approx(0.0, abs=1e-6)
    assert palm.score == pytest.approx(1 / (1 + math.exp(-SURE)))


@pytest.mark.parametrize("angle", [0.0, 0.7, -2.0, 3.0])
def test_its_crop_is_turned_with_the_fingers_and_lies_ahead_of_the_palm(angle):
    up = np.array([math.sin(angle), -math.cos(angle)])
    (palm,), _ = found([(600, SURE, box(up=20 * up))], SQUARE)
    box_px = 300 * BOX_PX / DETECTOR_SIDE
    assert palm.crop.angle == pytest.approx(angle, abs=1e-5)
    np.testing.assert_allclose(palm.crop.centre, 300 * anchors()[600] + HAND_SHIFT * box_px * up, atol=1e-3)


def test_unsure_ones_are_left_out_and_the_surest_comes_first():
    palms, _ = found([(0, -0.1, box()), (500, 1.0, box()), (1100, 2.0, box())])
    assert [palm.score for palm in palms] == pytest.approx([1 / (1 + math.exp(-2)), 1 / (1 + math.exp(-1))])


def test_overlapping_ones_are_one_palm_between_them():
    near = anchors()[600] * DETECTOR_SIDE - anchors()[602] * DETECTOR_SIDE
    (palm,), _ = found([(600, SURE, box()), (602, SURE, box(np.add(near, (4.0, 0.0))))], SQUARE)
    one, other = (found([(600, SURE, box(s))], SQUARE)[0][0].crop.centre for s in ((0.0, 0.0), (4.0, 0.0)))
    np.testing.assert_allclose(palm.crop.centre, (one + other) / 2, atol=1e-3)


@pytest.mark.parametrize("logit", [-1e9, 1e9])
def test_any_logit_gives_a_score(logit):
    palms, _ = found([(600, logit, box())])
    assert [palm.score for palm in palms] == ([] if logit < 0 else [pytest.approx(1.0)])


def test_a_box_without_extent_is_a_palm_of_its_own():
    palms, _ = found([(600, SURE, np.zeros(18)), (600, SURE, np.zeros(18)), (0, SURE, np.zeros(18))])
    assert len(palms) == 2


@pytest.mark.parametrize(
    ("shape", "rows", "columns"), [(LANDSCAPE, 144, 192), (PORTRAIT, 192, 144), (SQUARE, 192, 192)]
)
def test_the_picture_is_shown_whole_between_black_bars(shape, rows, columns):
    _, network = found([], shape)
    (shown,) = network.shown
    assert shown.shape == (DETECTOR_SIDE, DETECTOR_SIDE, 3)
    lit = shown[..., 0] > 0
    assert (np.count_nonzero(lit.any(axis=1)), np.count_nonzero(lit.any(axis=0))) == (rows, columns)
    np.testing.assert_allclose(shown[lit], 100 / 255, atol=1e-6)
    np.testing.assert_array_equal(lit, lit[::-1, ::-1])

"""Crops: the way from the crop to the picture and back, its brightness, and the crop for the next picture."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from local_site.tracking.landmarks.crop import BRIGHT_LEVEL, MOST_GAIN, Crop, upright
from local_site.tracking.landmarks.hand_landmarks import WRIST, HandLandmarks
from local_site.tracking.learned.hand_starts import FIST, FLAT, POINTING
from local_site.tracking.silhouette.hand_model.habits import GRIPPER
from tests.local_site.tracking.landmarks.seen_hands import PAIR_RIG, landmarks_of, seen_by_all
from tests.local_site.tracking.silhouette.hand_model.posed_hands import pose_of

SIZE_PX = 96
ANGLES = [0.0, 0.4, -1.3, math.pi / 2, 3.0]
AT = np.array([300.0, 200.0])


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def hand_of(points):
    return HandLandmarks(np.asarray(points, dtype=float), 0.9, 0.9, Crop(AT, 100.0, 0.0))


def middle_of(picture):
    """Where the light of a grey picture (H, W) lies, in px."""
    y, x = np.mgrid[: picture.shape[0], : picture.shape[1]]
    return np.array([(x * picture).sum(), (y * picture).sum()]) / picture.sum()


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("spot", [(300.0, 200.0), (322.0, 188.0), (281.0, 231.0)])
def test_what_is_cut_out_is_where_the_way_back_says(angle, spot):
    picture = np.zeros((480, 640, 3), np.uint8)
    cv2.circle(picture, (round(spot[0]), round(spot[1])), 4, (255, 255, 255), -1, cv2.LINE_AA)
    crop = Crop(AT, 140.0, angle)
    seen = middle_of(crop.cut(picture, SIZE_PX)[..., 0])
    back = crop.to_picture((seen[None] + 0.5) / SIZE_PX)[0]
    np.testing.assert_allclose(back, spot, atol=0.3)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_line_stands_upright_in_its_crop(angle):
    tail, head = AT, AT + turned(np.array([0.0, -50.0]), angle)
    crop = Crop((tail + head) / 2, 100.0, upright(tail, head))
    ends = crop.to_picture(np.array([[0.5, 0.75], [0.5, 0.25]]))
    np.testing.assert_allclose(ends, [tail, head], atol=1e-9)


def test_changes_turn_and_scale_about_the_centre():
    crop = Crop(AT, 100.0, 0.2).changed(turn=0.3, scale=1.5)
    assert (crop.side_px, crop.angle) == pytest.approx((150.0, 0.5))
    np.testing.assert_array_equal(crop.centre, AT)


@pytest.mark.parametrize(("level", "expected"), [(20, 20 * MOST_GAIN), (120, BRIGHT_LEVEL), (220, 220)])
def test_dark_hands_are_made_brighter_and_bright_ones_left(level, expected):
    cut = Crop(AT, 100.0, 0.3).cut(np.full((480, 640, 3), level, np.uint8), SIZE_PX)
    assert 255 * float(cut.mean()) == pytest.approx(expected, abs=0.5)


def test_colours_are_red_green_blue_and_end_at_one():
    picture = np.zeros((480, 640, 3), np.uint8)
    picture[:] = (20, 90, 250)
    cut = Crop(AT, 100.0, 0.0).cut(picture, SIZE_PX)
    np.testing.assert_allclose(255 * cut[48, 48], [250, 90, 20], atol=0.5)
    dark = np.full((480, 640, 3), 30, np.uint8)
    dark[170:180, 270:280] = 255
    assert Crop(AT, 100.0, 0.0).cut(dark, SIZE_PX).max() == 1.0


@pytest.mark.parametrize("centre", [(-500.0, 0.0), (1e4, 1e4)])
def test_outside_of_the_picture_all_is_black(centre):
    cut = Crop(np.array(centre), 100.0, 0.3).cut(np.full((480, 640, 3), 200, np.uint8), SIZE_PX)
    assert cut.shape == (SIZE_PX, SIZE_PX, 3)
    assert not cut.any()


@pytest.mark.parametrize("posture", [GRIPPER, FLAT, FIST, POINTING], ids=["gripper", "flat", "fist", "pointing"])
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.5, 0.5, 0.5), (-1.2, 0.0, 0.0), (0.0, 0.0, 2.0)])
def test_the_next_crop_holds_the_hand(posture, turn):
    for hand in seen_by_all(PAIR_RIG, landmarks_of(pose_of(turn, posture))):
        crop = hand.next_crop()
        inside = turned(hand.points - crop.centre, -crop.angle) / crop.side_px
        assert np.abs(inside).max() < 0.5
        assert np.ptp(inside, axis=0).max() > 0.3


def test_the_next_crop_shows_the_fingers_above_the_wrist():
    for hand in seen_by_all(PAIR_RIG, landmarks_of(pose_of(posture=FLAT))):
        crop = hand.next_crop()
        inside = turned(hand.points - crop.centre, -crop.angle)
        assert inside[WRIST, 1] > 0 > inside[12, 1]
        assert abs(inside[12, 0] - inside[WRIST, 0]) < 0.2 * crop.side_px


@given(st.floats(-3.1, 3.1), st.floats(0.3, 4.0), st.floats(-500, 500), st.floats(-500, 500))
def test_the_next_crop_goes_with_the_hand(angle, scale, x, y):
    points = seen_by_all(PAIR_RIG, landmarks_of(pose_of()))[0].points
    crop = hand_of(points).next_crop()
    other = hand_of(scale * turned(points, angle) + [x, y]).next_crop()
    np.testing.assert_allclose(other.centre, scale * turned(crop.centre, angle) + [x, y], atol=1e-6)
    assert other.side_px == pytest.approx(scale * crop.side_px)
    assert math.remainder(other.angle - crop.angle - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_hand_in_one_point_gives_a_crop_that_can_be_cut():
    crop = hand_of(np.full((21, 2), 100.0)).next_crop()
    assert np.isfinite(crop.cut(np.full((480, 640, 3), 90, np.uint8), SIZE_PX)).all()

"""The room by squares is the mean picture made small, whatever has been learned since."""

import cv2
import numpy as np
import pytest

from local_site.calibration.undistortion import TakenPicture, Undistorter
from local_site.tracking.foreground.room import STRIPS, RoomModel

SHAPE = (50, 64)


def picture(seed):
    taken = np.random.default_rng(seed).integers(40, 200, (*SHAPE, 3)).astype(np.uint8)
    return TakenPicture(taken, Undistorter(None, cv2.BORDER_REPLICATE))


def by_squares(levels, stride):
    rows, columns = SHAPE[0] // stride, SHAPE[1] // stride
    part = levels[: rows * stride, : columns * stride]
    return cv2.resize(part, (columns, rows), interpolation=cv2.INTER_AREA).transpose(2, 0, 1)


def behind(room, stride):
    """What is behind all squares, were today's picture the mean: the light is then as it was."""
    mean = by_squares(room.mean, stride)
    nothing = np.zeros(mean.shape[1:], np.uint8)
    return mean, room.behind(np.rint(mean).astype(np.uint8), nothing, (0, 0, stride))


@pytest.mark.parametrize("stride", [2, 3, 4])
def test_squares_follow_what_is_learned(stride):
    room = RoomModel(SHAPE)
    room.learn(picture(0))
    nothing = np.zeros(SHAPE, np.uint8)
    for k in range(STRIPS + 3):
        room.follow(picture(k), nothing)
        mean, found = behind(room, stride)
        assert np.allclose(found.colours, mean, rtol=0.01)


def test_squares_of_another_size_are_made_anew():
    room = RoomModel(SHAPE)
    room.learn(picture(0))
    for stride in (2, 4, 3):
        mean, found = behind(room, stride)
        assert np.allclose(found.colours, mean, rtol=0.01)


def test_a_part_of_the_picture_is_taken_from_its_place():
    room = RoomModel(SHAPE)
    room.learn(picture(0))
    mean = by_squares(room.mean, 2)[:, 5:12, 8:20]
    nothing = np.zeros(mean.shape[1:], np.uint8)
    found = room.behind(np.rint(mean).astype(np.uint8), nothing, (16, 10, 2))
    assert np.allclose(found.colours, mean, rtol=0.02)


def test_shadow_is_found_from_the_squares_around():
    room = RoomModel(SHAPE)
    room.learn(picture(0))
    mean = by_squares(room.mean, 2)
    dark = np.rint(0.6 * mean).astype(np.uint8)
    found = room.behind(dark, np.zeros(mean.shape[1:], np.uint8), (0, 0, 2))
    assert np.allclose(found.gain, 0.6, atol=0.02)
    assert np.allclose(found.colours, 0.6 * mean, rtol=0.05)


def test_nothing_is_known_before_anything_was_seen():
    room = RoomModel(SHAPE)
    found = room.behind(np.zeros((3, 25, 32), np.uint8), np.zeros((25, 32), np.uint8), (0, 0, 2))
    assert not found.known.any()

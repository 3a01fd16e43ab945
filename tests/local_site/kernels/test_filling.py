"""Hulls are those of OpenCV, and they are filled to the pixel as by OpenCV, but for where they leave the picture."""

import cv2
import numpy as np
import pytest

from local_site.kernels.filling import convex_hulls, fill_hulls

WIDTH, HEIGHT = 140, 100
RNG = np.random.default_rng(4)


def points(shift, spread_px):
    """Groups of points about the middle of the picture: round ones, flat ones and some of whole pixels."""
    groups = []
    for k in range(60):
        middle, spread = RNG.uniform((30, 30), (110, 70)), RNG.uniform(0.5, spread_px)
        turn = RNG.uniform(0.0, 2.0 * np.pi, int(RNG.integers(3, 60)))
        circle = middle + spread * np.column_stack([np.cos(turn), np.sin(turn)]) * (1.0, RNG.uniform(0.0, 1.0))
        groups.append(np.rint((np.rint(circle) if k % 3 == 0 else circle) * (1 << shift)).astype(np.int32))
    return groups


def filled(groups, shift):
    """What both draw of groups at levels of their own, one over the other."""
    ours, opencvs = np.zeros((2, HEIGHT, WIDTH), np.uint8)
    levels = np.arange(1, len(groups) + 1).astype(np.uint8)
    fill_hulls(ours, *convex_hulls(np.concatenate(groups), np.cumsum([len(group) for group in groups])), levels, shift)
    for group, level in zip(groups, levels.tolist(), strict=True):
        cv2.fillConvexPoly(opencvs, cv2.convexHull(group), level, cv2.LINE_8, shift)
    return ours, opencvs


@pytest.mark.parametrize("shift", [4, 6])
def test_hulls_within_the_picture_are_filled_as_by_opencv(shift):
    for _ in range(10):
        for group in points(shift, 25.0):
            ours, opencvs = filled([group], shift)
            assert np.array_equal(ours, opencvs)


def test_later_hulls_cover_earlier_ones():
    ours, opencvs = filled(points(6, 25.0), 6)
    assert np.array_equal(ours, opencvs)


def test_hulls_that_leave_the_picture_are_so_to_within_a_pixel():
    near = np.ones((3, 3), np.uint8)
    for group in points(6, 150.0):
        ours, opencvs = filled([group], 6)
        assert np.all(ours <= cv2.dilate(opencvs, near))
        assert np.all(opencvs <= cv2.dilate(ours, near))


def test_a_hull_has_the_corners_of_opencvs_uppermost_first():
    for group in points(6, 25.0):
        corners, (end,) = convex_hulls(group, np.array([len(group)]))
        assert {*map(tuple, corners[:end].tolist())} == {*map(tuple, cv2.convexHull(group)[:, 0].tolist())}
        assert corners[0, 1] == group[:, 1].min()

"""Tubes are drawn where they are seen, and the region grows from the hand and over a band on the wrist."""

import math

import numpy as np
import pytest

from local_site.tracking.foreground.growing import disc, within
from local_site.tracking.foreground.tubes import RatioMap, Tube

FOCAL_PX = 400.0
PROJECTION = np.array([[FOCAL_PX, 0, 160, 0], [0, FOCAL_PX, 120, 0], [0, 0, 1, 0]], float)


def squares(stride=2, left=40, top=20):
    return RatioMap(PROJECTION, FOCAL_PX, np.zeros((100, 120), np.float32), left, top, stride)


@pytest.mark.parametrize("wider", [0.5, 1.0, 1.6])
def test_a_tube_across_the_view_is_as_wide_as_it_is(wider):
    view = squares()
    tube = Tube(np.array([-0.1, 0.0, 1.0]), np.array([0.1, 0.0, 1.0]), (0.03, 0.03), (0.0,))
    drawn = within(view, tube, wider)
    middle_row = (120 - view.top) / view.stride - 0.25
    for column in range(40, 80):
        rows = np.flatnonzero(drawn[:, column])
        assert np.mean(rows) == pytest.approx(middle_row, abs=0.5)
        assert len(rows) == pytest.approx(2 * wider * 0.03 * FOCAL_PX / view.stride + 1, abs=1)


def test_a_tube_is_wider_where_it_is_near():
    tube = Tube(np.array([-0.1, 0.0, 1.4]), np.array([0.1, 0.0, 0.8]), (0.03, 0.03), (0.0,))
    heights = within(squares(), tube, 1.0).sum(axis=0)
    assert heights[80] > 1.3 * heights[50] > 0


def test_a_disc_has_its_area_and_ends_at_the_border():
    view = squares()
    radius = 0.05 * FOCAL_PX / view.stride + 0.5
    assert disc(view, np.array([0.0, 0.0, 1.0]), 0.05).sum() == pytest.approx(math.pi * radius**2, rel=0.03)
    left_edge = np.array([(view.left - 160) / FOCAL_PX, 0.0, 1.0])
    assert disc(view, left_edge, 0.05).sum() == pytest.approx(math.pi * radius**2 / 2, rel=0.12)


def test_what_is_outside_of_the_view_or_behind_it_draws_nothing_in_it():
    view = squares()
    assert not disc(view, np.array([2.0, 0.0, 1.0]), 0.05).any()

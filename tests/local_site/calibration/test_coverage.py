"""Coverage: how much of picture and volume the points reach, warned of when it is little, and drawn."""

from dataclasses import replace

import numpy as np
import pytest

from local_site.calibration.coverage import EMPTY, GOOD, coverage_map, coverage_warnings, draw_found, picture_coverage
from tests.local_site.calibration.plate_cameras import ANGLES, camera, control

SIZE = (640, 480)


def test_the_hull_of_the_points_is_measured():
    corners = np.array([(0.0, 0.0), (320.0, 0.0), (320.0, 480.0), (0.0, 480.0), (np.nan, np.nan)])
    assert picture_coverage(corners, SIZE) == pytest.approx(0.5)
    assert picture_coverage(corners[:2], SIZE) == 0.0


def test_well_spread_points_give_no_warning():
    assert coverage_warnings(replace(control(), sizes=(SIZE, SIZE))) == ()


def test_a_plate_far_away_is_warned_of_for_each_camera():
    far = control([camera(angle, distance=4.0) for angle in ANGLES])
    sentences = coverage_warnings(replace(far, sizes=(SIZE, None)))
    assert len(sentences) == 1
    assert sentences[0].startswith("left camera: the points cover ")
    assert "bring points nearer to its edges" in sentences[0]


def test_a_small_common_volume_is_warned_of():
    points = control()
    points.pixels[1][points.points[:, 2] > 0.2] = np.nan
    sentences = coverage_warnings(points)
    assert [s for s in sentences if "span 0 % of the volume along Z" in s]
    points.pixels[1][points.points[:, 0] > 0.3] = np.nan
    assert any("only 10 points are seen by two cameras" in s for s in coverage_warnings(points))


def test_the_map_shows_where_points_were_seen():
    drawn = coverage_map(np.array([(20.0, 20.0), (np.nan, np.nan)]), SIZE)
    assert drawn.shape == (480, 640, 3)
    assert drawn[60, 60].tolist() == [c // 2 for c in GOOD]
    assert drawn[300, 300].tolist() == [c // 2 for c in EMPTY]
    over = coverage_map(np.zeros((0, 2)), SIZE, np.full((480, 640), 200, np.uint8))
    assert over[300, 300].tolist() == [100 + c // 2 for c in EMPTY]


def test_what_was_found_is_drawn_where_it_was():
    drawn = draw_found(np.zeros((100, 100), np.uint8), np.array([(30.0, 40.0), (80.0, 80.0)]), ["1,1", "2,1"])
    assert drawn[40, 30].any()
    assert drawn[80, 80].any()
    assert not drawn[90, 10].any()

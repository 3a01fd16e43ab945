"""The rooms behind the arm: drawn from a seed, and seen by every camera where they are."""

from typing import get_args

import numpy as np
import pytest

from lab.films.picture.rigs import film_cameras
from lab.films.room.rooms import DESK, DESK_SHAPE, WALL, WALL_SHAPE, FurnishedRoom, RoomName, furnished
from lab.films.surroundings import SeenRoom

SIZE = (320, 240)
RED, GREEN = (0, 0, 255), (0, 255, 0)


@pytest.mark.parametrize("name", get_args(RoomName))
def test_a_room_is_another_for_each_seed_and_the_same_for_one(name):
    one, same, other = furnished(name, 1), furnished(name, 1), furnished(name, 2)
    assert np.array_equal(one.wall, same.wall)
    assert not np.array_equal(one.wall, other.wall)
    assert not np.array_equal(one.desk, other.desk)


def _px(plane, point):
    """Where a point (3,) in m lies on a plane's picture."""
    return (round(plane.px_per_m * (point - plane.corner) @ axis) for axis in (plane.across, plane.down))


@pytest.mark.parametrize("rig", ["standard", "distorted"])
def test_every_camera_sees_points_of_wall_and_desk_where_they_are(rig):
    wall, desk = np.zeros((*WALL_SHAPE, 3), np.uint8), np.zeros((*DESK_SHAPE, 3), np.uint8)
    on_wall, on_desk = np.array([0.3, WALL.corner[1], 0.6]), np.array([0.45, 0.8, DESK.corner[2]])
    x, y = _px(WALL, on_wall)
    wall[y - 15 : y + 16, x - 15 : x + 16] = RED
    x, y = _px(DESK, on_desk)
    desk[y - 15 : y + 16, x - 15 : x + 16] = GREEN
    for camera in film_cameras(rig, SIZE):
        picture = SeenRoom(FurnishedRoom(wall, desk), camera, SIZE).at(0.0)
        for point, channel in ((on_wall, 2), (on_desk, 1)):
            rows, columns = np.nonzero(picture[..., channel] > 100)
            assert (columns.mean(), rows.mean()) == pytest.approx(camera.pixels(point), abs=1.0)


def test_shadows_move_over_wood_and_the_fan_turns():
    camera = film_cameras("standard", SIZE)[0]
    for name in ("wood", "fan"):
        seen = SeenRoom(furnished(name, 1), camera, SIZE)
        assert np.array_equal(seen.at(0.1), seen.at(0.1))
        assert np.abs(seen.at(0.0) - seen.at(0.5)).max() > 20


def test_what_stands_still_stays_the_same_and_may_be_drawn_on():
    seen = SeenRoom(furnished("plain", 1), film_cameras("standard", SIZE)[0], SIZE)
    first = seen.at(0.0)
    kept = first.copy()
    first[:] = 0
    assert np.array_equal(seen.at(1.0), kept)

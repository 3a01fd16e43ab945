"""A surface's picture appears where the camera sees the surface, and only where the mask lets it."""

import numpy as np

from remote_site.simulation.dressing import PaintedSurface, Rectangle
from remote_site.video.backdrop import Backdrop, Eye

WIDTH, HEIGHT, FOCAL_PX = 160, 120, 100.0
RED, GREEN, GREY = (0, 0, 255), (0, 255, 0), (90, 90, 90)
EVERYWHERE = np.full((HEIGHT, WIDTH), 255, dtype=np.uint8)
AHEAD = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])  # looks along x, y to the left, z up


def eye(x=0.0):
    return Eye(np.array([x, 0.0, 0.0]), AHEAD, FOCAL_PX, WIDTH, HEIGHT)


def wall(*, of_table=False):
    """A wall of 1 m two metres ahead, facing the camera at x = 0; grey, its upper left quarter red."""
    picture = np.full((100, 100, 3), GREY, dtype=np.uint8)
    picture[:50, :50] = RED
    corner = np.array([2.0, 0.5, -0.5])
    rectangle = Rectangle(corner, np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, 1.0]))
    return Backdrop([PaintedSurface(rectangle, picture, of_table)])


def drawn(backdrop, camera, where=EVERYWHERE, *, of_table=False):
    picture = np.full((HEIGHT, WIDTH, 4), (*GREEN, 0), dtype=np.uint8)
    backdrop.draw(camera, picture, where, of_table=of_table)
    return picture[:, :, 2::-1]


def is_of(picture, colour):
    return (picture == colour).all(axis=2)


def test_a_wall_appears_where_and_as_large_as_it_projects():
    picture = drawn(wall(), eye())
    rows, columns = np.nonzero(~is_of(picture, GREEN))
    assert np.abs(np.array([rows.min(), rows.max(), columns.min(), columns.max()]) - [35, 85, 55, 105]).max() <= 1
    assert is_of(picture[40:55, 60:75], RED).all(), "upper left"
    assert is_of(picture[65:80, 85:100], GREY).all(), "lower right"


def test_a_wall_is_not_seen_from_behind():
    behind = Eye(np.array([4.0, 0.0, 0.0]), AHEAD @ np.diag([-1.0, 1.0, -1.0]), FOCAL_PX, WIDTH, HEIGHT)
    assert is_of(drawn(wall(), behind), GREEN).all()


def test_the_mask_and_the_kind_are_respected():
    left = EVERYWHERE.copy()
    left[:, 80:] = 0
    assert is_of(drawn(wall(), eye(), left)[:, 80:], GREEN).all()
    assert is_of(drawn(wall(), eye(), of_table=True), GREEN).all()
    assert not is_of(drawn(wall(of_table=True), eye(), of_table=True), GREEN).all()


def test_a_floor_that_reaches_behind_the_camera_ends_at_the_horizon():
    corner = np.array([50.0, 50.0, -1.0])
    floor = Rectangle(corner, np.array([0.0, -100.0, 0.0]), np.array([-100.0, 0.0, 0.0]))
    upwards = Rectangle(floor.corner + floor.up, floor.right, -floor.up)
    picture = drawn(
        Backdrop([PaintedSurface(upwards, np.full((64, 64, 3), RED, dtype=np.uint8), of_table=False)]), eye()
    )
    assert is_of(picture[:58], GREEN).all()
    assert is_of(picture[64:], RED).all()

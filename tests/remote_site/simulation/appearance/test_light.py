"""Baked light: shadow where a box stands between lamp and floor, none elsewhere."""

import numpy as np
import pytest

from remote_site.simulation.appearance.light import AMBIENT, KEY, TO_LAMP, baked, lamp_points
from remote_site.simulation.appearance.surfaces import Rectangle, box_corners

FLOOR = Rectangle(np.array([1.0, -1.0, 0.0]), np.array([0.0, 2.0, 0.0]), np.array([-2.0, 0.0, 0.0]))
MIDDLE = np.zeros(3)
LAMP = lamp_points(MIDDLE, 3.0)
SHAPE = (80, 80)


def light(*boxes):
    return baked(FLOOR, SHAPE, boxes, LAMP, MIDDLE)


def at(field, x, y):
    row, column = (1.0 + x) / 2.0 * SHAPE[0], (y + 1.0) / 2.0 * SHAPE[1]
    return field[int(row), int(column)]


def box(centre, half):
    return box_corners(np.array(centre) - half, np.array(centre) + half)


def test_an_empty_floor_has_all_light_where_the_lamp_is_aimed():
    straight = TO_LAMP[2] ** 2  # by the cosines at the floor and at the lamp
    assert at(light(), 0.0, 0.0) == pytest.approx(AMBIENT + KEY * straight, rel=0.06)


def test_a_box_throws_its_shadow_away_from_the_lamp():
    height = 0.8
    shaded, empty = light(box((0.0, 0.0, height), 0.15)), light()
    foot = -TO_LAMP[:2] / TO_LAMP[2] * height
    assert at(shaded, *foot) < 0.75 * at(empty, *foot)
    assert at(shaded, *-foot) > 0.93 * at(empty, *-foot)


def test_a_shadow_is_the_softer_the_higher_the_box():
    edges = []
    for height in (0.12, 1.0):
        shadow = (light(box((0.0, 0.0, height), 0.1)) / light()).astype(float)
        edges.append(np.abs(np.diff(shadow, axis=0)).max())
    assert edges[0] > 2.0 * edges[1]


def test_a_box_below_the_floor_throws_none():
    assert (light(box((0.0, 0.0, -0.5), 0.2)) == light()).all()

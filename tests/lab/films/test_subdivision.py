"""One step of Catmull and Clark's subdivision, where the result is known."""

import numpy as np
import pytest

from lab.films.arm.subdivision import subdivided

CUBE = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
CUBE_QUADS = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)], np.int32)


def test_a_cube_becomes_rounder_as_the_rule_says():
    fine, quads = subdivided(CUBE_QUADS, len(CUBE))
    vertices = fine @ CUBE
    assert vertices.shape == (8 + 6 + 12, 3)
    assert quads.shape == (24, 4)
    assert np.abs(vertices[:8]) == pytest.approx(np.full((8, 3), 5 / 9))
    assert np.linalg.norm(vertices[8:14], axis=1) == pytest.approx(np.ones(6))


def test_fine_quads_face_where_the_coarse_ones_face():
    fine, quads = subdivided(CUBE_QUADS, len(CUBE))
    a, b, c, _ = (fine @ CUBE)[quads.T]
    outwards = np.sum(np.cross(b - a, c - a) * a, axis=1)
    coarse_a, coarse_b, coarse_c, _ = CUBE[CUBE_QUADS.T]
    assert np.all(np.sign(outwards) == np.sign(np.sum(np.cross(coarse_b - coarse_a, coarse_c - coarse_a) * coarse_a)))


def test_a_flat_sheet_stays_flat_and_its_straight_rim_straight():
    sheet = np.array([(x, y, 0.0) for y in range(3) for x in range(3)])
    quads = np.array([(k, k + 1, k + 4, k + 3) for k in (0, 1, 3, 4)], np.int32)
    fine, _ = subdivided(quads, len(sheet))
    vertices = fine @ sheet
    assert np.all(vertices[:, 2] == 0.0)
    assert vertices[1] == pytest.approx([1.0, 0.0, 0.0])
    assert np.asarray(fine.sum(axis=1)) == pytest.approx(np.ones(len(vertices)))

"""Medial lines: the fast formula is the thesis's cloud of midpoints, and tapered limbs give their own axis."""

import math

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from local_site.tracking.features.medial import Edges, MedialLine, limb_sides, medial_line, scan_edges
from local_site.tracking.features.silhouette import find_silhouette, to_grey
from tests.present import present


def drawn_limb(centre, angle, length=120.0, widths=(34.0, 24.0)):
    """A picture of a tapered limb about a line, and the line."""
    direction = np.array([math.cos(angle), math.sin(angle)])
    normal = np.array([-direction[1], direction[0]])
    ends = [centre - 0.5 * length * direction, centre + 0.5 * length * direction]
    corners = [ends[0] + 0.5 * widths[0] * normal, ends[1] + 0.5 * widths[1] * normal]
    corners += [ends[1] - 0.5 * widths[1] * normal, ends[0] - 0.5 * widths[0] * normal]
    image = np.full((240, 320), 10, dtype=np.uint8)
    cv2.fillPoly(image, [np.round(np.array(corners) * 16).astype(np.int32)], 150, cv2.LINE_AA, 4)
    return image, MedialLine(np.asarray(centre, dtype=float), direction)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.floats(-math.pi, math.pi), st.floats(-0.15, 0.15), st.floats(-4, 4))
def test_the_axis_of_a_tapered_limb_is_found_from_a_rough_guess(angle, turn, shift):
    image, truth = drawn_limb(np.array([160.0, 120.0]), angle)
    silhouette = find_silhouette(to_grey(image), 80.0)
    assert silhouette is not None
    c, s = math.cos(turn), math.sin(turn)
    guess = MedialLine(truth.point + shift * truth.normal, np.array([[c, -s], [s, c]]) @ truth.direction)
    for _ in range(3):
        line = medial_line(scan_edges(silhouette, guess, -50, 50, 40), -45, 45)
        assert line is not None
        guess = MedialLine(line.at(line.along(truth.point)), line.direction)
    assert abs(float(guess.direction @ truth.normal)) < 0.01
    assert abs(float(truth.normal @ (guess.point - truth.point))) < 0.4


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 10_000))
def test_it_is_the_line_through_all_midpoints(seed):
    random = np.random.default_rng(seed)
    t = np.arange(40.0)
    upper, lower = 10 + random.normal(0, 0.7, 40).cumsum() / 3, -9 + random.normal(0, 0.7, 40).cumsum() / 3
    line = medial_line(Edges(MedialLine(np.zeros(2), np.array([1.0, 0.0])), t, lower, upper), 0, 39)
    assert line is not None
    points = [np.column_stack([t, edge]) for edge in (upper, lower)]
    cloud = 0.5 * (points[0][:, None] + points[1][None, :]).reshape(-1, 2)
    direction = np.linalg.eigh(np.cov(cloud.T))[1][:, -1]
    assert np.allclose(line.point, cloud.mean(axis=0))
    assert abs(abs(float(direction @ line.direction)) - 1) < 1e-12


def test_too_few_rows_give_no_line():
    image, truth = drawn_limb(np.array([160.0, 120.0]), 0.3)
    silhouette = find_silhouette(to_grey(image), 80.0)
    assert silhouette is not None
    assert medial_line(scan_edges(silhouette, truth, 0, 20, 40), 0, 3) is None
    assert medial_line(scan_edges(silhouette, truth, 200, 220, 40), 200, 220) is None


def test_each_side_of_a_limb_is_found_without_the_other():
    image, axis = drawn_limb(np.array([160.0, 120.0]), 0.4, widths=(30.0, 30.0))
    both = limb_sides(present(find_silhouette(to_grey(image), 80.0)), axis, -20, 20, 30)
    assert np.allclose(both, [-15, 15], atol=0.6)
    flesh = np.array([axis.at(t) + d * axis.normal for t, d in ((-50, 0), (50, 0), (50, 60), (-50, 60))])
    cv2.fillPoly(image, [np.round(flesh * 16).astype(np.int32)], 150, cv2.LINE_AA, 4)
    back = limb_sides(present(find_silhouette(to_grey(image), 80.0)), axis, -20, 20, 30)
    assert abs(back[0] + 15) < 0.6
    assert np.isnan(back[1])


def test_a_limb_that_leaves_the_picture_has_no_edges_beyond_it():
    image, truth = drawn_limb(np.array([160.0, 10.0]), math.radians(50), widths=(40.0, 40.0))
    silhouette = find_silhouette(to_grey(image), 80.0)
    assert silhouette is not None
    edges = scan_edges(silhouette, truth, -55, 50, 60)
    seen = ~np.isnan(edges.lower)
    across = np.stack([truth.at(t) + s * truth.normal for t in edges.t[seen] for s in (-20.0, 20.0)])
    assert 20 < np.count_nonzero(seen) < 70
    assert across.min() > -1.0
    line = medial_line(edges, -55, 50)
    assert line is not None
    assert abs(float(line.direction @ truth.normal)) < 0.02

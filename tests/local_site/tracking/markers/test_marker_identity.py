"""Correspondence and identity: which spots are one marker, and which marker is which."""

import itertools

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.tracking.markers.correspondence import Candidates, correspond
from local_site.tracking.markers.identity import NO_CANDIDATE, Spans, first_identity, next_identity
from local_site.tracking.markers.learned import span_lengths
from local_site.tracking.markers.spots import Spots
from tests.local_site.tracking.markers.marker_scene import HAND, four_cameras, hand_at

GATE_PX = 4.0
NOTHING = np.full((3, 3), np.nan)
LEARNED = Spans(tuple(span_lengths(HAND)))
PROJECTIONS = [camera.projection for camera in four_cameras()]


def seen(points, views=2, order=None):
    """The spots of points (N, 3) in some views, each in an order of its own."""
    found = []
    for k in range(views):
        pixels = project(PROJECTIONS[k], points)
        if order is not None:
            pixels = pixels[list(order[k])]
        found.append(Spots(pixels, pixels, np.full(len(pixels), 0.05), np.full(len(pixels), 80.0)))
    return found


def candidates(points, views=2, order=None):
    return correspond(PROJECTIONS[:views], seen(points, views, order), GATE_PX)


def places(found, identity):
    return np.array([np.full(3, np.nan) if k == NO_CANDIDATE else found.points[k] for k in identity.chosen])


@pytest.mark.parametrize("views", [2, 3, 4])
def test_lines_of_sight_that_meet_make_a_candidate_of_all_views(views):
    found = candidates(hand_at(), views)
    full = found.points[(found.members >= 0).all(axis=1)]
    for point in hand_at():
        assert np.linalg.norm(full - point, axis=1).min() < 1e-9


def test_a_view_in_which_a_marker_is_hidden_is_left_out():
    spots = seen(hand_at(), 3)
    spots[1] = seen(hand_at()[:2], 3)[1]
    found = correspond(PROJECTIONS[:3], spots, GATE_PX)
    nearest = int(np.argmin(np.linalg.norm(found.points - hand_at()[2], axis=1)))
    assert found.members[nearest].tolist() == [2, -1, 2]
    assert found.points[nearest] == pytest.approx(hand_at()[2])


def test_views_that_do_not_fit_give_nothing():
    spots = seen(hand_at())
    spots[1] = seen(hand_at((0, 0, 0.03)))[1]
    assert not np.any(np.linalg.norm(correspond(PROJECTIONS[:2], spots, GATE_PX).points - hand_at()[0], axis=1) < 0.05)


@pytest.mark.parametrize("turn", [(0, 0, 0), (0.5, 0, 0), (0, 0.6, 0.3), (-0.4, 0.2, -0.6)])
def test_at_the_start_geometry_tells_who_is_who_in_any_order(turn):
    points = hand_at(turn=turn)
    for order in itertools.permutations(range(3)):
        found = candidates(points, order=[(0, 1, 2), order])
        identity = first_identity(found, GATE_PX)
        assert places(found, identity) == pytest.approx(points)
        assert not identity.doubtful.any()


@pytest.mark.parametrize(
    "shape",
    [
        HAND[:2],
        np.array([[0, 0, 0], [-0.15, 0, 0.06], [-0.15, 0, -0.06]]),
        np.array([[0, 0, 0], [-0.5, 0, 0], [-0.4, 0.1, 0]]),
    ],
    ids=["two markers", "index as far as thumb", "no human hand"],
)
def test_what_is_no_hand_or_not_clear_is_nobody(shape):
    identity = first_identity(candidates(hand_at(shape=shape)), GATE_PX)
    assert (identity.chosen == NO_CANDIDATE).all()


def test_learned_distances_tell_who_is_who_without_a_past():
    points = hand_at((0.1, 0.05, -0.1), (0.2, 0.5, 0.1))
    found = candidates(points, order=[(2, 0, 1), (1, 0, 2)])
    assert places(found, next_identity(found, LEARNED, NOTHING, GATE_PX)) == pytest.approx(points)


@pytest.mark.parametrize("hidden", [0, 1, 2])
def test_of_two_markers_the_past_tells_which(hidden):
    points = hand_at((0.01, 0.0, 0.005))
    found = candidates(np.delete(points, hidden, axis=0))
    identity = next_identity(found, LEARNED, hand_at(), GATE_PX)
    assert identity.chosen[hidden] == NO_CANDIDATE
    rest = np.delete(np.arange(3), hidden)
    assert places(found, identity)[rest] == pytest.approx(points[rest])
    assert not identity.doubtful[rest].any()


def test_two_markers_without_a_past_are_not_guessed():
    found = candidates(hand_at()[:2])
    identity = next_identity(found, LEARNED, NOTHING, GATE_PX)
    assert np.all((identity.chosen == NO_CANDIDATE) | identity.doubtful)


def test_a_stray_light_is_not_taken_for_a_hidden_marker():
    points = np.vstack([hand_at()[:2], hand_at()[2] + [0.05, 0.05, -0.08]])
    found = candidates(points)
    identity = next_identity(found, LEARNED, hand_at(), GATE_PX)
    assert identity.chosen[2] == NO_CANDIDATE or identity.doubtful[2]
    assert places(found, identity)[:2] == pytest.approx(points[:2])


def test_a_hand_that_jumped_is_believed_when_complete():
    points = hand_at((0.15, 0.0, 0.0))
    found = candidates(points)
    assert places(found, next_identity(found, LEARNED, hand_at(), GATE_PX)) == pytest.approx(points)


def test_two_candidates_that_cannot_both_be_true_are_not_both_taken():
    points = hand_at()
    members = np.array([[0, 0], [1, 1], [2, 2], [2, 1]])
    ghost = points[2] + [0.004, 0.0, 0.0]
    found = Candidates(np.vstack([points, ghost]), members, np.zeros(4))
    identity = next_identity(found, LEARNED, points, GATE_PX)
    assert places(found, identity) == pytest.approx(points)

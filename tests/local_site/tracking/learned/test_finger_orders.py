"""Landmarks that take the index for the little finger in one view: the outlines tell."""

import numpy as np
import pytest

from local_site.calibration.triangulation import project, triangulate_many
from local_site.tracking.learned.finger_orders import (
    REVERSED,
    in_likely_order,
    is_as_told,
    is_contradicted,
    possible_orders,
    reversed_fingers,
    thumb_agrees,
)
from local_site.tracking.learned.followed_hand import FollowedHand
from local_site.tracking.learned.hand_starts import POINTING
from local_site.tracking.silhouette.hand_model.habits import GRIPPER
from local_site.tracking.silhouette.hand_model.skeleton import INDEX_TIP, THUMB_TIP, hand_spheres
from tests.local_site.tracking.landmarks.seen_hands import landmark_views, landmarks_of
from tests.local_site.tracking.silhouette.hand_model.posed_hands import PERSON, PROJECTIONS, hand_view, pose_of

SIGMA_PX = 4.0
NEAR_M, FAR_M = 0.008, 0.015
ACROSS_M = np.array([0.0, 0.0, 0.1])
INDEX, LITTLE_FINGER, THUMB = slice(5, 9), slice(17, 21), slice(1, 5)
TURNS = {"usual": (0.0, 0.0, 0.0), "aslant": (0.6, 0.3, -0.4)}


def views_of(pose, mistaken=None, outlined=True):
    """The hand in both views, one of them `mistaken`: index and little finger, middle and ring finger exchanged."""
    shown = landmark_views(landmarks_of(pose), SIGMA_PX)
    views = []
    for k, view in enumerate(shown):
        pixels = view.landmarks[list(REVERSED)] if k == mistaken else view.landmarks
        outline = hand_view(pose, PERSON, PROJECTIONS[k]) if outlined else view
        views.append(outline._replace(landmarks=pixels, landmark_sigma=SIGMA_PX))
    return views


def tracked(hand, views):
    seen = triangulate_many(PROJECTIONS, np.stack([view.landmarks for view in views], axis=1))
    return hand.track(views, seen, None)


def index_error_m(found, pose):
    return float(np.linalg.norm(found.index.point - hand_spheres(pose, PERSON).tip(INDEX_TIP)))


@pytest.mark.parametrize("mistaken", [0, 1])
@pytest.mark.parametrize("posture", [GRIPPER, POINTING], ids=["gripper", "pointing"])
@pytest.mark.parametrize("turn", TURNS)
def test_outlines_tell_which_finger_is_the_index(turn, posture, mistaken):
    pose, hand = pose_of(TURNS[turn], posture), FollowedHand(True, None)
    found = tracked(hand, views_of(pose, mistaken))
    assert index_error_m(found, pose) < NEAR_M
    assert np.linalg.norm(found.thumb.point - hand_spheres(pose, PERSON).tip(THUMB_TIP)) < NEAR_M


@pytest.mark.parametrize("mistaken", [0, 1])
def test_a_mistake_while_a_hand_is_followed_moves_nothing(mistaken):
    hand = FollowedHand(True, None)
    for instant in range(12):
        pose = pose_of((0.03 * instant, 0.0, 0.0))
        found = tracked(hand, views_of(pose, mistaken if instant > 3 else None))
        assert index_error_m(found, pose) < NEAR_M


def test_without_outlines_the_landmarks_are_believed_as_they_are_told():
    pose = pose_of(posture=POINTING)
    right, mistaken = (tracked(FollowedHand(True, None), views_of(pose, k, outlined=False)) for k in (None, 0))
    assert index_error_m(right, pose) < NEAR_M
    assert index_error_m(mistaken, pose) > FAR_M


def test_reversed_fingers_have_no_thumb():
    landmarks = np.arange(42, dtype=float).reshape(21, 2)
    other = reversed_fingers(landmarks)
    np.testing.assert_array_equal(other[INDEX], landmarks[LITTLE_FINGER])
    np.testing.assert_array_equal(other[0], landmarks[0])
    assert np.isnan(other[THUMB]).all()
    assert not np.isnan(np.delete(other, np.r_[THUMB], axis=0)).any()
    np.testing.assert_array_equal(landmarks, np.arange(42.0).reshape(21, 2))


def test_the_order_nearer_to_the_expected_one_is_taken():
    view = views_of(pose_of())[0]
    expected = project(view.projection, landmarks_of(pose_of((0.1, 0.0, 0.0))))
    assert in_likely_order(view, expected) is view
    exchanged = view._replace(landmarks=view.landmarks[list(REVERSED)])
    np.testing.assert_array_equal(in_likely_order(exchanged, expected).landmarks[INDEX], view.landmarks[INDEX])


def test_each_view_in_turn_is_reversed_and_one_without_landmarks_is_not():
    first, second = views_of(pose_of())
    assert len(possible_orders([first, second])) == 3
    unseen = second._replace(landmarks=np.empty((0, 2)))
    told, other = possible_orders([first, unseen])
    assert told == [first, unseen]
    assert other[1] is unseen
    assert np.isnan(other[0].landmarks[THUMB]).all()


def test_a_thumb_on_the_wrong_side_disagrees():
    views, points = views_of(pose_of()), landmarks_of(pose_of())
    assert thumb_agrees(views, points)
    wrong = points.copy()
    wrong[THUMB] += 2 * (points[17] - points[5])
    assert not thumb_agrees(views, wrong)
    thumbless = [view._replace(landmarks=reversed_fingers(view.landmarks)) for view in views]
    assert thumb_agrees(thumbless, wrong)


@pytest.mark.parametrize("finger", [THUMB, INDEX], ids=["thumb", "index"])
def test_a_hand_is_contradicted_where_every_view_tells_a_finger_elsewhere(finger):
    views, points = views_of(pose_of()), landmarks_of(pose_of())
    wrong = points.copy()
    wrong[finger] += ACROSS_M
    assert is_contradicted(views, wrong)
    assert not is_contradicted(views, points)
    assert not is_contradicted([view._replace(landmarks=np.empty((0, 2))) for view in views], wrong)
    agreeing = views[0]._replace(landmarks=project(views[0].projection, wrong))
    assert not is_contradicted([agreeing, views[1]], wrong)


def test_views_are_as_told_while_their_landmarks_are():
    views = views_of(pose_of())
    assert is_as_told(list(views), views)
    assert not is_as_told([views[0], views[1]._replace(landmarks=reversed_fingers(views[1].landmarks))], views)

"""The hand from instant to instant: learned, followed, opened, lost and found."""

import numpy as np
import pytest

from local_site.tracking.silhouette.hand_model.habits import GRIPPER, Habits, LimbEvidence
from local_site.tracking.silhouette.hand_model.skeleton import INDEX_TIP, THUMB_TIP, TYPICAL_FOREARM, hand_spheres
from local_site.tracking.silhouette.hand_tracker import HandTracker
from tests.local_site.tracking.silhouette.hand_model.posed_hands import (
    PERSON,
    TO_ELBOW,
    WRIST_COVARIANCE,
    far_end,
    hand_views,
    pose_of,
)

PAIRS = 4
# Measured at most 6.6 and 1.5 mm.
INDEX_M, THUMB_M = 0.009, 0.004
STEP_DEG = 3.0


def course(k):
    """The k-th pose of a hand that moves and turns."""
    turn = np.radians(STEP_DEG) * k * np.array([0.5, 0.6, 0.6])
    return pose_of(turn, wrist=np.array([0.50, 0.45, 0.60]) + 0.004 * k * np.array([-1.0, 0.0, 0.5]))


def arm_of(pose):
    elbow = pose.wrist + TYPICAL_FOREARM * TO_ELBOW
    return LimbEvidence(pose.wrist, WRIST_COVARIANCE, elbow, far_end(pose))


def track(tracker, pose):
    return tracker.track(hand_views(pose), arm_of(pose))


def settled():
    """A tracker that knows the hand, and the number of the next pose."""
    tracker = HandTracker(PAIRS, right_arm=True)
    for k in range(6):
        assert track(tracker, course(k)) is not None
    assert tracker.known
    return tracker, 6


def opened(pose):
    return pose_of(posture=Habits().opened.posture, wrist=pose.wrist)


def test_a_moving_hand_is_learned_and_followed():
    tracker = HandTracker(PAIRS, right_arm=True)
    for k in range(12):
        pose = course(k)
        assert tracker.known == (k >= PAIRS)
        hand, truth = track(tracker, pose), hand_spheres(pose, PERSON)
        assert hand is not None
        assert np.linalg.norm(hand.index.point - truth.tip(INDEX_TIP)) < INDEX_M
        assert np.linalg.norm(hand.thumb.point - truth.tip(THUMB_TIP)) < THUMB_M
        assert not hand.hand_open
        for covariance in (hand.index.covariance, hand.thumb.covariance):
            assert np.linalg.eigvalsh(covariance)[0] > 0


def test_an_opened_hand_is_open_until_it_closes():
    tracker, k = settled()
    pose = course(k)
    hands = [track(tracker, opened(pose)) for _ in range(2)]
    assert all(hand is not None and hand.hand_open for hand in hands)
    closed = [track(tracker, pose_of(posture=GRIPPER, wrist=pose.wrist)) for _ in range(2)]
    assert closed[-1] is not None
    assert not closed[-1].hand_open


def test_opening_teaches_no_habit():
    tracker, k = settled()
    before = tracker._habits.learned
    track(tracker, opened(course(k)))
    assert tracker._habits.learned == before


@pytest.mark.parametrize("jump", [(1.5, 0.0, 0.0), (0.0, 0.0, -0.9), (-2.5, 0.3, 0.0)])
def test_a_hand_that_turned_out_of_sight_is_found_again(jump):
    tracker, k = settled()
    tracker.forget()
    pose = pose_of(jump[0] * pose_of().rotation[:, 0] + np.array([0.0, jump[1], jump[2]]), wrist=course(k).wrist)
    hand = track(tracker, pose)
    assert hand is not None
    assert np.linalg.norm(hand.index.point - hand_spheres(pose, PERSON).tip(INDEX_TIP)) < INDEX_M
    assert tracker.known


def test_outlines_of_no_hand_are_none():
    tracker, k = settled()
    pose, other = course(k), pose_of((0.0, 1.2, 1.2), wrist=course(k).wrist + np.array([0.0, 0.0, 0.02]))
    views = [hand_views(pose)[0], hand_views(other)[1]]
    assert tracker.track(views, arm_of(pose)) is None
    assert track(tracker, pose) is not None


def test_the_number_of_views_that_show_a_tip_is_told():
    tracker, k = settled()
    hand = track(tracker, course(k))
    assert hand is not None
    assert 1 <= hand.index.views <= 2
    assert hand.thumb.views == 2

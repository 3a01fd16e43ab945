"""The search finds a hand of which nothing is known but where wrist and far end are."""

import numpy as np
import pytest

from local_site.tracking.silhouette.hand_model.fit import Effort, Prior, search_hand
from local_site.tracking.silhouette.hand_model.habits import GRIPPER, GRIPPER_SIGMA, Habits
from local_site.tracking.silhouette.hand_model.skeleton import INDEX_TIP, THUMB_TIP, HandPose, Person, hand_spheres
from tests.local_site.tracking.silhouette.hand_model.posed_hands import (
    MIRROR,
    PERSON,
    PROJECTIONS,
    TO_ELBOW,
    angle_deg,
    far_end,
    hand_views,
    known,
    pose_of,
)

ROLLS, KEPT = 24, 6
HANDS = 20
INDEX_M, THUMB_M, TURN_DEG = 0.007, 0.010, 3.0
# Measured on 40 hands 0.97 and 0.9: a thumb behind the palm in both views shows nowhere.
FOUND, THUMB_FOUND = 0.9, 0.8


def searched(views, pose, person=PERSON):
    prior = Prior(pose.wrist, np.eye(3), GRIPPER, known(Habits().closed, False))
    return search_hand(views, far_end(pose, person), prior, person, Effort(ROLLS, KEPT))


@pytest.mark.slow
def test_hands_of_many_shapes_are_found_from_nothing():
    random, index, thumb, turn_deg = np.random.default_rng(0), [], [], []
    for _ in range(HANDS):
        posture = GRIPPER + 0.5 * GRIPPER_SIGMA * random.normal(size=len(GRIPPER))
        pose = pose_of(0.4 * random.normal(size=3), posture)
        fit, truth = searched(hand_views(pose), pose), hand_spheres(pose, PERSON)
        index.append(np.linalg.norm(fit.spheres.tip(INDEX_TIP) - truth.tip(INDEX_TIP)))
        thumb.append(np.linalg.norm(fit.spheres.tip(THUMB_TIP) - truth.tip(THUMB_TIP)))
        turn_deg.append(angle_deg(fit.pose.rotation, pose.rotation))
    assert np.mean(np.array(index) < INDEX_M) >= FOUND
    assert np.mean(np.array(turn_deg) < TURN_DEG) >= FOUND
    assert np.mean(np.array(thumb) < THUMB_M) >= THUMB_FOUND


@pytest.mark.parametrize("roll", np.radians([0, 100, 200, 300]))
def test_a_hand_of_any_roll_is_found(roll):
    axis = pose_of().rotation[:, 0]
    pose = pose_of(roll * axis)
    fit, truth = searched(hand_views(pose), pose), hand_spheres(pose, PERSON)
    assert np.linalg.norm(fit.spheres.tip(INDEX_TIP) - truth.tip(INDEX_TIP)) < INDEX_M


def test_a_left_hand_is_found_as_a_left_one_and_fits_worse_as_a_right_one():
    right = pose_of((0.2, 0.1, -0.2))
    pose = HandPose(MIRROR @ right.wrist, MIRROR @ right.rotation @ np.diag([1.0, -1.0, 1.0]), GRIPPER)
    left, other = Person(1.0, False, MIRROR @ TO_ELBOW), Person(1.0, True, MIRROR @ TO_ELBOW)
    views = hand_views(pose, left, [m @ np.diag([-1.0, 1.0, 1.0, 1.0]) for m in PROJECTIONS])
    fit, truth = searched(views, pose, left), hand_spheres(pose, left)
    assert np.linalg.norm(fit.spheres.tip(INDEX_TIP) - truth.tip(INDEX_TIP)) < INDEX_M
    assert np.linalg.norm(fit.spheres.tip(THUMB_TIP) - truth.tip(THUMB_TIP)) < THUMB_M
    assert searched(views, pose, other).cost > 2 * fit.cost

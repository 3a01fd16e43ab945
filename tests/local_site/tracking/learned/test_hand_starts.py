"""A hand's first pose from landmarks in space: size, the typical posture, and rotations that never mirror."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from local_site.tracking.learned.hand_starts import (
    FIST,
    FLAT,
    POINTING,
    TYPICAL,
    any_posture,
    laid_upon,
    pose_from_landmarks,
    right_by_shape,
    scale_of,
)
from local_site.tracking.silhouette.hand_model.habits import GRIPPER, Habits
from local_site.tracking.silhouette.hand_model.skeleton import PALM, Person
from tests.local_site.tracking.landmarks.seen_hands import landmarks_of
from tests.local_site.tracking.silhouette.hand_model.posed_hands import MIRROR, TO_ELBOW, angle_deg, pose_of

SIZES = np.zeros(3)
RIGHT = Person(1.0, True, TO_ELBOW)
LEFT = Person(1.0, False, TO_ELBOW)
POSTURES = {"gripper": GRIPPER, "flat": FLAT, "fist": FIST, "pointing": POINTING}


@pytest.mark.parametrize("seed", range(5))
def test_points_are_laid_upon_their_moved_copies(seed):
    random = np.random.default_rng(seed)
    points, shift = random.normal(size=(21, 3)), random.normal(size=3)
    turn = Rotation.random(random_state=seed).as_matrix()
    rotation, translation, off = laid_upon(points, points @ turn.T + shift)
    np.testing.assert_allclose(rotation, turn, atol=1e-9)
    np.testing.assert_allclose(translation, shift, atol=1e-9)
    assert off < 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_a_mirror_image_is_turned_but_never_mirrored(seed):
    points = np.random.default_rng(seed).normal(size=(21, 3))
    rotation, _, off = laid_upon(points, points @ MIRROR)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    assert off > 0.1


@pytest.mark.parametrize("points", [np.zeros((5, 3)), np.outer(np.arange(5.0), [1.0, 2.0, 3.0])], ids=["point", "line"])
def test_points_without_a_shape_give_a_rotation_nevertheless(points):
    rotation, translation, off = laid_upon(points, points + 1.0)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-9)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    np.testing.assert_allclose(points @ rotation.T + translation, points + 1.0, atol=1e-9)
    assert off < 1e-9


def test_what_is_left_is_the_rms_distance():
    points = np.random.default_rng(3).normal(size=(21, 3))
    other = points + 0.05 * np.random.default_rng(4).normal(size=points.shape)
    rotation, translation, off = laid_upon(points, other)
    left = points @ rotation.T + translation - other
    assert off == pytest.approx(np.sqrt(np.mean(np.sum(left**2, axis=1))))
    assert off <= np.sqrt(np.mean(np.sum((points - other) ** 2, axis=1)))


@pytest.mark.parametrize("name", POSTURES)
@pytest.mark.parametrize("scale", [0.8, 1.0, 1.15])
@pytest.mark.parametrize("right_arm", [True, False])
def test_the_size_is_the_same_in_every_posture(name, scale, right_arm):
    pose = pose_of((0.4, -0.6, 1.0), POSTURES[name])
    landmarks = landmarks_of(pose, Person(scale, right_arm, TO_ELBOW))
    assert scale_of(landmarks, right_arm) == pytest.approx(scale, rel=1e-6)


def test_one_wrong_knuckle_does_not_change_the_size_by_much():
    landmarks = landmarks_of(pose_of())
    landmarks[5] += [0.0, 0.0, 0.3]
    assert scale_of(landmarks, True) == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("name", POSTURES)
@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (1.5, 0.3, -0.2), (0.0, 0.0, 3.0), (-1.0, 2.0, 0.5)])
def test_each_typical_posture_is_recognised_however_it_is_turned(name, turn):
    truth = pose_of(turn, POSTURES[name])
    start = pose_from_landmarks(landmarks_of(truth, RIGHT), RIGHT, SIZES)
    np.testing.assert_allclose(start.posture, truth.posture, atol=1e-12)
    np.testing.assert_allclose(start.wrist, truth.wrist, atol=1e-9)
    assert angle_deg(start.rotation, truth.rotation) < 1e-3


def test_a_left_hands_posture_is_recognised_as_a_left_ones():
    truth = pose_of((0.3, 0.4, 0.1), POINTING)
    start = pose_from_landmarks(landmarks_of(truth, LEFT), LEFT, SIZES)
    np.testing.assert_allclose(start.posture, POINTING, atol=1e-12)
    assert angle_deg(start.rotation, truth.rotation) < 1e-3


@pytest.mark.parametrize("name", ["gripper", "fist", "pointing"])
@pytest.mark.parametrize("person", [RIGHT, LEFT], ids=["right", "left"])
def test_bent_fingers_tell_the_side(name, person):
    share = right_by_shape(landmarks_of(pose_of((0.4, -0.6, 1.0), POSTURES[name]), person))
    assert share > 0.8 if person.right_arm else share < 0.2


def test_a_flat_hand_tells_less_but_never_the_wrong_side():
    right, left = (right_by_shape(landmarks_of(pose_of(posture=FLAT), person)) for person in (RIGHT, LEFT))
    assert 0.5 < right <= 1.0
    assert left == pytest.approx(1.0 - right)


def test_any_posture_is_believed_loosely_and_keeps_the_known_sizes():
    own = Habits().own
    sizes = own.posture.copy()
    sizes[PALM:] = (0.05, -0.04, 0.02)
    belief = any_posture(type(own)(sizes, own.information))
    np.testing.assert_array_equal(belief.posture[PALM:], sizes[PALM:])
    made, given = (np.linalg.inv(b.information)[PALM:, PALM:] for b in (belief, own))
    np.testing.assert_allclose(made, given, rtol=1e-6)
    for typical in TYPICAL:
        off = (typical - belief.posture)[:PALM]
        assert off @ belief.information[:PALM, :PALM] @ off < 2.5 * PALM

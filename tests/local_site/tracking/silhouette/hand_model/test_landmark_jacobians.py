"""The normal equations of landmarks agree with finite differences of their cost, and each landmark is its joint."""

import numpy as np
import pytest

from local_site.tracking.silhouette.hand_model.landmark_equations import CREASE, add_landmarks, landmark_points
from local_site.tracking.silhouette.hand_model.outline_equations import project_spheres
from local_site.tracking.silhouette.hand_model.skeleton import (
    INDEX_TIP,
    MIDDLE_KNUCKLE,
    MIDDLE_TIP,
    POSE,
    STATE,
    THUMB_TIP,
    WRIST,
    HandPose,
    hand_spheres,
    turned,
)
from tests.local_site.tracking.landmarks.seen_hands import landmark_views, landmarks_of
from tests.local_site.tracking.silhouette.hand_model.posed_hands import PERSON, pose_of

STEP = 1e-5
SIGMA_PX = 3.0
NEVER_ROBUST, ROBUST = 1e6, 1.5
POSES = [(0.0, 0.0, 0.0), (0.5, -0.3, 0.2), (-0.8, 0.2, 0.6)]


def moved(pose, step):
    return HandPose(pose.wrist + step[:3], turned(step[3:POSE]) @ pose.rotation, pose.posture + step[POSE:])


def equations(view, pose, robust):
    """Information, gradient and cost of a view's landmarks for a hand in a pose."""
    circles = project_spheres(view.projection, view.focal_px, hand_spheres(pose, PERSON))
    information, gradient = np.zeros((STATE, STATE)), np.zeros(STATE)
    cost = add_landmarks(view.landmarks, circles, view.landmark_sigma, robust, information, gradient)
    return information, gradient, cost


def slope(view, pose, robust):
    """The cost's central differences (16,) by the hand's state."""
    steps = STEP * np.eye(STATE)
    return np.array(
        [
            (equations(view, moved(pose, s), robust)[2] - equations(view, moved(pose, -s), robust)[2]) / (2 * STEP)
            for s in steps
        ]
    )


@pytest.mark.parametrize("robust", [NEVER_ROBUST, ROBUST])
@pytest.mark.parametrize("turn", POSES)
def test_the_gradient_is_half_the_slope_of_the_cost(turn, robust):
    off = pose_of(np.array(turn) + 0.08)
    for view in landmark_views(landmarks_of(pose_of(turn)), SIGMA_PX):
        _, gradient, cost = equations(view, off, robust)
        expected = slope(view, off, robust)
        assert cost > 0
        np.testing.assert_allclose(2 * gradient, expected, rtol=5e-3, atol=2e-3 * np.abs(expected).max())


def test_the_information_is_the_curvature_at_the_truth():
    pose = pose_of()
    for view in landmark_views(landmarks_of(pose), SIGMA_PX):
        information, gradient, cost = equations(view, pose, NEVER_ROBUST)
        assert cost < 0.05  # the crease lies between joints that are projected each by itself
        assert (np.abs(gradient) < 0.05 * np.sqrt(information.diagonal()) + 1e-6).all()
        whole = information + np.tril(information, -1).T
        assert np.linalg.eigvalsh(whole)[0] > -1e-6 * np.trace(whole)
        for p in range(STATE):
            step = 1e-3 * np.eye(STATE)[p]
            rise = equations(view, moved(pose, step), NEVER_ROBUST)[2] - cost
            assert rise == pytest.approx(whole[p, p] * 1e-6 + 2 * gradient[p] * 1e-3, rel=0.05, abs=1e-3)


def test_one_far_landmark_hardly_pulls():
    pose = pose_of()
    view = landmark_views(landmarks_of(pose), SIGMA_PX)[0]
    spoilt = view.landmarks.copy()
    spoilt[8] += 100.0
    view = view._replace(landmarks=spoilt)
    plain, robust = (np.linalg.norm(equations(view, pose, limit)[1]) for limit in (NEVER_ROBUST, ROBUST))
    assert robust < 0.01 * plain


def test_no_landmarks_add_nothing():
    view = landmark_views(landmarks_of(pose_of()), SIGMA_PX)[0]._replace(landmarks=np.empty((0, 2)))
    information, gradient, cost = equations(view, pose_of(), ROBUST)
    assert cost == 0
    assert not information.any()
    assert not gradient.any()


@pytest.mark.parametrize(
    ("landmark", "sphere"), [(4, THUMB_TIP), (8, INDEX_TIP), (9, MIDDLE_KNUCKLE), (12, MIDDLE_TIP)]
)
def test_each_landmark_is_its_joint(landmark, sphere):
    centres = hand_spheres(pose_of((0.2, 0.1, -0.3)), PERSON).centres
    np.testing.assert_allclose(landmark_points(centres)[landmark], centres[sphere], atol=1e-12)


def test_the_wrists_landmark_is_on_the_crease_ahead_of_the_joint():
    pose = pose_of((0.2, 0.1, -0.3))
    spheres = hand_spheres(pose, PERSON)
    ahead = landmark_points(spheres.centres)[0] - spheres.centres[WRIST : WRIST + 2].mean(axis=0)
    to_knuckle = spheres.centres[MIDDLE_KNUCKLE] - spheres.centres[WRIST : WRIST + 2].mean(axis=0)
    np.testing.assert_allclose(ahead, CREASE * to_knuckle, atol=1e-12)

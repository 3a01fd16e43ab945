"""The compiled derivatives of the hand model agree with finite differences of what they are derivatives of."""

from typing import Any

import numpy as np
import pytest

from local_site.tracking.silhouette.hand_model.fit import contact
from local_site.tracking.silhouette.hand_model.outline_equations import (
    Contact,
    add_outline,
    add_outside,
    project_spheres,
)
from local_site.tracking.silhouette.hand_model.skeleton import (
    POSE,
    STATE,
    HandPose,
    hand_spheres,
    rotation_vector,
    turned,
)
from tests.local_site.tracking.silhouette.hand_model.posed_hands import PERSON, hand_views, pose_of

STEP = 1e-5
HAND = 20
# A row leaves out that a sphere looks smaller farther away, which is 1.1 % of its largest entry.
CLOSE = 0.02
NEVER_ROBUST = 1e6
POSES = [(0.0, 0.0, 0.0), (0.5, -0.3, 0.2), (-0.8, 0.2, 0.6)]


def moved(pose, step):
    return HandPose(pose.wrist + step[:3], turned(step[3:POSE]) @ pose.rotation, pose.posture + step[POSE:])


def differences(function, pose):
    """Central differences (..., 16) of a function of a pose."""
    columns = []
    for p in range(STATE):
        step = np.zeros(STATE)
        step[p] = STEP
        columns.append((function(moved(pose, step)) - function(moved(pose, -step))) / (2 * STEP))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("turn", POSES)
def test_spheres_move_as_said(turn):
    pose = pose_of(turn)
    spheres = hand_spheres(pose, PERSON)
    near: dict[str, Any] = {"rtol": 2e-3, "atol": 2e-5}
    np.testing.assert_allclose(
        spheres.centre_jacobian, differences(lambda p: hand_spheres(p, PERSON).centres, pose), **near
    )
    np.testing.assert_allclose(
        spheres.radius_jacobian, differences(lambda p: hand_spheres(p, PERSON).radii, pose), **near
    )


@pytest.mark.parametrize("turn", POSES)
def test_outline_rows_are_changes_of_the_distances(turn):
    truth, off = pose_of(turn), pose_of(np.array(turn) + 0.05)
    for view in hand_views(truth):
        spheres = hand_spheres(off, PERSON)
        now = contact(view, spheres, view.pixels)
        circles = project_spheres(view.projection, view.focal_px, spheres)
        expected = differences(lambda p, v=view: contact(v, hand_spheres(p, PERSON), v.pixels).distance, off)
        steady = _steady(view, off, now.capsule)
        assert np.mean(steady) > 0.8
        for n in np.flatnonzero(steady & (np.abs(now.distance) > 0.2)):
            information, gradient = np.zeros((STATE, STATE)), np.zeros(STATE)
            one = Contact(now.distance[[n]], now.capsule[[n]], now.fraction[[n]])
            cost = add_outline(view.pixels[[n]], one, circles, 1.0, NEVER_ROBUST, information, gradient)
            row = gradient / now.distance[n]
            np.testing.assert_allclose(row, expected[n], rtol=0, atol=CLOSE * np.abs(expected[n]).max())
            np.testing.assert_allclose(
                np.tril(information), np.tril(np.outer(row, row)), rtol=1e-6, atol=1e-6 * float(row @ row)
            )
            assert cost == pytest.approx(now.distance[n] ** 2, rel=1e-6)


def _steady(view, pose, capsule):
    """Which pixels (N,) touch the same capsule a small distance away."""
    same = np.ones(len(capsule), dtype=bool)
    for p in range(STATE):
        for sign in (-2 * STEP, 2 * STEP):
            step = np.zeros(STATE)
            step[p] = sign
            same &= contact(view, hand_spheres(moved(pose, step), PERSON), view.pixels).capsule == capsule
    return same


def test_spheres_outside_the_silhouette_are_drawn_in():
    truth, off = pose_of(), pose_of((0.25, -0.2, 0.25))
    view = hand_views(truth)[0]

    def added(pose):
        circles = project_spheres(view.projection, view.focal_px, hand_spheres(pose, PERSON))
        information, gradient = np.zeros((STATE, STATE)), np.zeros(STATE)
        cost = add_outside(view.field, view.origin, circles, HAND, view.sigma, (1.0, 1e6), information, gradient)
        return cost, information, gradient

    cost, information, gradient = added(off)
    assert cost > 1.0
    assert added(truth)[0] < 0.02 * cost
    slope = differences(lambda p: np.array(added(p)[0]), off)
    np.testing.assert_allclose(2 * gradient, slope, rtol=0.02, atol=0.02 * np.abs(slope).max())
    assert np.linalg.eigvalsh(information)[0] > -1e-6 * np.trace(information)


@pytest.mark.parametrize("vector", [(0.0, 0.0, 0.0), (1e-7, 0.0, 0.0), (0.3, -0.5, 0.2), (2.0, 1.5, -1.0)])
def test_turns_and_their_vectors_agree(vector):
    rotation = turned(np.array(vector))
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(rotation_vector(rotation), vector, atol=1e-9)

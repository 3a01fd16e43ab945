"""A finger tip is the less sure, the fewer views show its end and the farther its edges are from the hand's model."""

import numpy as np
import pytest

from local_site.tracking.silhouette.tips import FREEDOM_M, INDEX, THUMB, _covariance

SHOWN = 0.001**2 * np.eye(3)
AHEAD = np.array([0.0, 0.9, 0.0])
NO_SHIFT = np.zeros(3)


def sigma_m(finger, seen, shift=NO_SHIFT, spread=SHOWN):
    return np.sqrt(np.trace(_covariance(finger, shift, spread, seen, AHEAD)))


@pytest.mark.parametrize("finger", [INDEX, THUMB])
def test_fewer_views_are_less_sure(finger):
    assert sigma_m(finger, 0) >= sigma_m(finger, 1) > sigma_m(finger, 2) > 0


def test_a_thumb_behind_the_hand_is_hardly_known():
    assert sigma_m(THUMB, 0) > 0.03
    assert sigma_m(THUMB, 3) < 0.006


@pytest.mark.parametrize("finger", [INDEX, THUMB])
def test_edges_beside_the_model_are_less_sure(finger):
    assert sigma_m(finger, 2, np.array([0.012, 0.0, 0.0])) > 1.1 * sigma_m(finger, 2)


@pytest.mark.parametrize("finger", [INDEX, THUMB])
def test_what_edges_leave_open_is_not_sure(finger):
    spread = np.diag([0.001**2, 0.001**2, FREEDOM_M**2])
    axes = np.diag(_covariance(finger, NO_SHIFT, spread, 2, AHEAD))
    assert axes[2] > 4 * axes[0]


def test_a_thumb_shown_by_all_is_least_sure_in_depth():
    axes = np.diag(_covariance(THUMB, NO_SHIFT, SHOWN, 2, AHEAD))
    assert axes[1] > 4 * axes[0]
    np.testing.assert_allclose(axes[0], axes[2])

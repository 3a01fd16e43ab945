"""What makes elbow and wrist less sure: flesh around the elbow's axis, a straight arm, the palm's beginning."""

import numpy as np
import pytest

from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.silhouette.joints import Joints, elbow_covariance, wrist_covariance
from local_site.tracking.silhouette.limbs import LIMBS

STEREO = StereoConfig()
ELBOW, FOREARM, HINGE = np.array([0.6, 0.4, 0.45]), np.array([-1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
LINES = 0.002**2 * np.eye(6)


def views(half_width_m):
    """Two views that show a limb so wide."""
    records = np.zeros(2, LIMBS)
    for record, matrix in zip(records, exact_rig(STEREO).matrices, strict=True):
        distance = float(matrix[2, :3] @ ELBOW + matrix[2, 3])
        record["projection"], record["focal_px"] = matrix, STEREO.focal_px
        record["half_width"] = half_width_m * STEREO.focal_px / distance
    return records


def bent(angle_deg):
    """An arm with this many degrees between its limbs, across the y axis; None for an upper arm that is not known."""
    turn = np.radians(angle_deg or 0.0)
    upper_arm = np.array([-np.cos(turn), 0.0, np.sin(turn)]) if angle_deg is not None else np.zeros(3)
    return Joints(ELBOW, ELBOW + 0.27 * FOREARM, LINES, 0.3, upper_arm)


def sigma_m(angle_deg, direction, half_width_m=0.04):
    return np.sqrt(direction @ elbow_covariance(bent(angle_deg), views(half_width_m)) @ direction)


def test_more_flesh_is_less_sure():
    assert sigma_m(90.0, FOREARM, 0.05) > 1.2 * sigma_m(90.0, FOREARM, 0.04) > 1.4 * sigma_m(90.0, FOREARM, 0.03)
    assert sigma_m(90.0, FOREARM, 0.01) == pytest.approx(sigma_m(90.0, HINGE, 0.05))


@pytest.mark.parametrize("angle_deg", [60.0, 90.0, 130.0])
def test_flesh_moves_the_axis_in_the_plane_of_the_arm(angle_deg):
    assert sigma_m(angle_deg, HINGE) < 0.5 * sigma_m(angle_deg, FOREARM)
    assert sigma_m(angle_deg, HINGE) < 0.5 * sigma_m(angle_deg, np.array([0.0, 0.0, 1.0]))


def test_a_straight_arm_leaves_the_elbow_open_along_the_forearm():
    along = [sigma_m(angle, FOREARM) for angle in (90.0, 120.0, 150.0)]
    assert along == sorted(along)
    assert along[-1] > 2 * along[0]


@pytest.mark.parametrize("angle_deg", [None, 180.0, 0.0])
def test_an_arm_without_a_bend_has_a_covariance(angle_deg):
    covariance = elbow_covariance(bent(angle_deg), views(0.04))
    assert np.isfinite(covariance).all()
    assert np.linalg.eigvalsh(covariance)[0] > 0
    assert sigma_m(angle_deg, HINGE) > 0.003


def test_the_wrist_is_least_sure_along_the_forearm():
    covariance = wrist_covariance(bent(90.0))
    along, across = np.sqrt(FOREARM @ covariance @ FOREARM), np.sqrt(HINGE @ covariance @ HINGE)
    assert along > 1.5 * across

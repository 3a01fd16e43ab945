"""Elbow and wrist from exact lines of both views, also where the planes alone leave them open."""

from dataclasses import replace

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.features.features import Features
from local_site.tracking.features.medial import line_through
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.silhouette.joints import Body, sleeve_end, solve_joints, upper_arm_direction
from local_site.tracking.silhouette.limbs import FOREARM_DEPTH_M, UPPER_ARM_DEPTH_M, limbs_of

STEREO = StereoConfig()
PROJECTIONS = exact_rig(STEREO).matrices
ELBOW = np.array([0.62, 0.42, 0.42])
BENT = np.array([0.43, 0.37, 0.61])
SHOULDER = ELBOW + np.array([0.20, -0.05, 0.14])
LENGTH = float(np.linalg.norm(BENT - ELBOW))
BLANK = Silhouette(np.zeros((480, 640), np.uint8), 40.0, np.array([[300.0, 200.0], [310.0, 210.0]]))
CROPPED = Silhouette(BLANK.grey, 40.0, np.array([[300.0, 200.0], [639.0, 210.0]]))


def beside(matrix, elbow, line, depth_m):
    """The skin (2, 2) on both sides of a limb whose axis lies everywhere so deep beneath it."""
    half_px = depth_m * STEREO.focal_px / float(matrix[2, :3] @ elbow + matrix[2, 3])
    return line.point + np.array([[-half_px], [half_px]]) * line.normal


def seen(elbow, wrist, shoulder, neck=True, upper=True, rough=0.0, cropped=True, thickness=1.0):
    """The exact features in every view of an arm without flesh, with the guesses `rough` px off."""
    features = []
    for matrix in PROJECTIONS:
        e, w, s = (project(matrix, p) for p in (elbow, wrist, shoulder))
        forearm, upper_arm = line_through(e, w), line_through(e, s)
        assert forearm is not None
        features.append(
            Features(
                forearm=forearm,
                root=forearm,
                forearm_sides=beside(matrix, elbow, forearm, FOREARM_DEPTH_M),
                upper_arm=upper_arm if upper else None,
                upper_arm_sides=beside(matrix, elbow, upper_arm, thickness * UPPER_ARM_DEPTH_M),
                wrist=w if neck else None,
                hand=None,
                half_width=20.0,
                silhouette=CROPPED if cropped else BLANK,
                guess=Posture(s, e + rough, w if neck else w + rough, w, 20.0),
            )
        )
    return features


def solved(features, body=None):
    joints = solve_joints(limbs_of(PROJECTIONS, features), features, body or Body())
    assert joints is not None
    return joints


def error_m(found, truth):
    return float(np.linalg.norm(found - truth))


def test_exact_lines_give_the_joints_back():
    joints = solved(seen(ELBOW, BENT, SHOULDER))
    assert error_m(joints.elbow, ELBOW) < 1e-3
    assert error_m(joints.wrist, BENT) < 1e-3
    assert joints.misfit < 0.1


def test_the_forearm_length_places_a_wrist_without_a_neck():
    joints = solved(seen(ELBOW, BENT, SHOULDER, neck=False, rough=8.0), Body(LENGTH))
    assert error_m(joints.wrist, BENT) < 0.003


@pytest.mark.parametrize("upper", [True, False])
def test_a_straight_arm_has_its_elbow_a_forearm_from_the_wrist(upper):
    joints = solved(seen(ELBOW, BENT, ELBOW + 0.9 * (ELBOW - BENT), upper=upper), Body(LENGTH))
    assert error_m(joints.elbow, ELBOW) < 0.003


def test_one_view_of_the_upper_arm_tells_where_the_arm_s_back_is():
    both = seen(ELBOW, BENT, SHOULDER)
    one = [both[0], replace(both[1], upper_arm=None)]
    found, direction = upper_arm_direction(limbs_of(PROJECTIONS, one), ELBOW, SHOULDER)
    assert found
    assert direction @ (SHOULDER - ELBOW) > 0.98 * np.linalg.norm(SHOULDER - ELBOW)


def test_less_is_known_where_less_is_seen():
    full = solved(seen(ELBOW, BENT, SHOULDER), Body(LENGTH))
    poor = solved(seen(ELBOW, BENT, SHOULDER, neck=False, upper=False))
    assert poor.elbow_sigma > 3 * full.elbow_sigma
    assert poor.wrist_sigma > 3 * full.wrist_sigma
    assert np.linalg.eigvalsh(full.covariance)[0] > 0


def test_a_thicker_arm_turns_nearer_to_its_back():
    plain = solved(seen(ELBOW, BENT, SHOULDER))
    moved = solved(seen(ELBOW, BENT, SHOULDER, thickness=1.3))
    inward = (BENT - ELBOW) / LENGTH + (SHOULDER - ELBOW) / error_m(SHOULDER, ELBOW)
    shift = moved.elbow - plain.elbow
    assert float(shift @ inward) < 0
    # The upper arm's middle lies 0.3 times UPPER_ARM_DEPTH_M farther from its back.
    assert 0.8 < np.linalg.norm(shift) / (0.3 * UPPER_ARM_DEPTH_M) < 2.5


def test_the_upper_arm_points_to_the_shoulder():
    found, direction = upper_arm_direction(limbs_of(PROJECTIONS, seen(ELBOW, BENT, SHOULDER)), ELBOW, BENT)
    assert found
    assert float(direction @ (SHOULDER - ELBOW)) == pytest.approx(error_m(SHOULDER, ELBOW), rel=1e-9)
    hidden = limbs_of(PROJECTIONS, seen(ELBOW, BENT, SHOULDER, upper=False))
    assert not upper_arm_direction(hidden, ELBOW, SHOULDER)[0]


def test_an_upper_arm_along_the_baseline_points_to_its_far_end():
    shoulder = ELBOW + np.array([0.2, 0.0, 0.0])
    views = limbs_of(PROJECTIONS, seen(ELBOW, BENT, shoulder))
    for far_end in (shoulder, 2 * ELBOW - shoulder):
        found, direction = upper_arm_direction(views, ELBOW, far_end)
        assert found
        assert float(direction @ (far_end - ELBOW)) == pytest.approx(0.2, rel=1e-2)


def test_a_sleeve_ends_where_all_views_agree():
    features = seen(ELBOW, BENT, SHOULDER, cropped=False)
    end = sleeve_end(PROJECTIONS, features)
    assert end is not None
    assert error_m(end, SHOULDER) < 1e-6
    apart = [features[0], seen(ELBOW, BENT, SHOULDER + np.array([0.0, 0.0, 0.1]), cropped=False)[1]]
    assert sleeve_end(PROJECTIONS, apart) is None
    assert sleeve_end(PROJECTIONS, seen(ELBOW, BENT, SHOULDER)) is None

"""Elbow and wrist from exact lines of both views, also where the planes alone leave them open."""

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.silhouette.contour import Silhouette
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.joints import Body, solve_joints
from local_site.tracking.silhouette.medial import line_through
from local_site.tracking.silhouette.posture import Posture

PROJECTIONS = exact_rig(StereoConfig()).matrices
ELBOW = np.array([0.62, 0.42, 0.42])
BENT = np.array([0.43, 0.37, 0.61])
SHOULDER = np.array([0.20, -0.05, 0.14])
BLANK = Silhouette(np.zeros((480, 640), np.uint8), 40.0, np.array([[300.0, 200.0], [310.0, 210.0]]), 1.0)


def seen(elbow, wrist, shoulder, neck=True, upper=True, rough=0.0):
    """The exact features of an arm in every view, with the guesses `rough` px off."""
    features = []
    for matrix in PROJECTIONS:
        e, w, s = (project(matrix, p) for p in (elbow, wrist, shoulder))
        forearm, upper_arm = line_through(e, w), line_through(e, s)
        assert forearm is not None
        guess = Posture(s, e + rough, w if neck else w + rough, w, 20.0)
        features.append(
            Features(forearm, upper_arm if upper else None, w if neck else None, None, 20.0, BLANK, guess, False, True)
        )
    return features


def error_m(found, truth):
    return float(np.linalg.norm(found - truth))


def test_exact_lines_give_the_joints_back():
    joints = solve_joints(PROJECTIONS, seen(ELBOW, BENT, ELBOW + SHOULDER), Body())
    assert joints is not None
    assert error_m(joints.elbow, ELBOW) < 1e-3
    assert error_m(joints.wrist, BENT) < 1e-3
    assert joints.misfit < 0.1


def test_the_forearm_length_places_a_wrist_without_a_neck():
    length = error_m(ELBOW, BENT)
    features = seen(ELBOW, BENT, ELBOW + SHOULDER, neck=False, rough=8.0)
    joints = solve_joints(PROJECTIONS, features, Body(length))
    assert joints is not None
    assert error_m(joints.wrist, BENT) < 0.003


@pytest.mark.parametrize("upper", [True, False])
def test_a_straight_arm_has_its_elbow_a_forearm_from_the_wrist(upper):
    shoulder = ELBOW + 0.9 * (ELBOW - BENT)
    joints = solve_joints(PROJECTIONS, seen(ELBOW, BENT, shoulder, upper=upper), Body(error_m(ELBOW, BENT)))
    assert joints is not None
    assert error_m(joints.elbow, ELBOW) < 0.003


def test_less_is_known_where_less_is_seen():
    shoulder = ELBOW + SHOULDER
    full = solve_joints(PROJECTIONS, seen(ELBOW, BENT, shoulder), Body(0.28))
    poor = solve_joints(PROJECTIONS, seen(ELBOW, BENT, shoulder, neck=False, upper=False), Body())
    assert full is not None
    assert poor is not None
    assert poor.elbow_sigma > 3 * full.elbow_sigma


def test_the_elbow_turns_behind_the_axes_of_both_limbs():
    shoulder = ELBOW + SHOULDER
    plain = solve_joints(PROJECTIONS, seen(ELBOW, BENT, shoulder), Body())
    moved = solve_joints(PROJECTIONS, seen(ELBOW, BENT, shoulder), Body(dorsal_offset=0.04))
    assert plain is not None
    assert moved is not None
    inward = (BENT - ELBOW) / error_m(BENT, ELBOW) + (shoulder - ELBOW) / error_m(shoulder, ELBOW)
    shift = moved.elbow - plain.elbow
    assert float(shift @ inward) < 0
    assert 0.04 * 0.25 < np.linalg.norm(shift) < 0.04 * 0.6

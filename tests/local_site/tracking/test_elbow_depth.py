"""Where in the limbs the elbow turns: what a camera beside, behind or anywhere sees of it."""

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.silhouette.contour import Silhouette
from local_site.tracking.silhouette.elbow_depth import (
    CLEAR_BEND_SINE,
    FOREARM_OFFSET_SHARE,
    UPPER_ARM_DEPTH_M,
    behind,
    elbow_shifts,
    unit,
)
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.joints import Body, solve_joints
from local_site.tracking.silhouette.limbs import limbs_of
from local_site.tracking.silhouette.medial import line_through
from local_site.tracking.silhouette.posture import Posture

FOCAL_PX, DISTANCE_M = 800.0, 1.5
PX_PER_M = FOCAL_PX / DISTANCE_M
# Looks along y from DISTANCE_M before the origin; pixels run along x and against z.
CAMERA = np.array([[FOCAL_PX, 320.0, 0.0, 320 * DISTANCE_M], [0, 240, -FOCAL_PX, 240 * DISTANCE_M], [0, 1, 0, 1.5]])
ELBOW = np.zeros(3)
X, Y, Z = np.eye(3)
THICK_M = 0.09
BLANK = Silhouette(np.zeros((480, 640), np.uint8), 40.0, np.array([[300.0, 200.0], [310.0, 210.0]]), 1.0)


def view_of(matrix, forearm_from, wrist, upper_from, shoulder, width_px, root_share=0.0):
    """The features of limbs whose middles run between these points (3,)."""
    a, w, b, s = (project(matrix, p) for p in (forearm_from, wrist, upper_from, shoulder))
    forearm = line_through(a, w)
    return Features(
        forearm=forearm,
        root=forearm,
        root_width=width_px,
        root_share=root_share,
        upper_arm=line_through(b, s),
        upper_arm_width=width_px,
        wrist=w,
        hand=None,
        half_width=0.5 * width_px,
        silhouette=BLANK,
        guess=Posture(s, a, w, w, 0.5 * width_px),
        hand_cropped=False,
        shoulder_cropped=True,
    )


def seen(wrist, shoulder, width_px, root_share=0.0):
    return view_of(CAMERA, ELBOW, wrist, ELBOW, shoulder, width_px, root_share)


def shifts_of(view, forearm, upper_arm):
    """Forearm's and upper arm's shift in px, seen by CAMERA, of limbs along unit vectors (3,)."""
    return elbow_shifts(limbs_of([CAMERA], [view])[0], ELBOW, forearm, upper_arm)


def along(line_normal, direction):
    """Pixels along a normal for each metre along a direction, at the elbow."""
    return float(line_normal @ (project(CAMERA, 1e-6 * direction) - project(CAMERA, ELBOW))) / 1e-6


def test_from_the_side_the_whole_offset_shows_towards_the_back():
    view = seen(0.28 * X, 0.2 * Z, THICK_M * PX_PER_M)
    forearm_px, upper_arm_px = shifts_of(view, X, Z)
    forearm_m = FOREARM_OFFSET_SHARE * 0.5 * THICK_M
    upper_arm_m = 0.5 * THICK_M - UPPER_ARM_DEPTH_M
    assert forearm_px == pytest.approx(along(view.root.normal, -forearm_m * Z), rel=1e-3)
    assert upper_arm_px == pytest.approx(along(view.upper_arm.normal, -upper_arm_m * X), rel=1e-3)
    assert abs(forearm_px) > 3


@pytest.mark.parametrize("sight", [-1, 1])
def test_from_before_or_behind_nothing_shows(sight):
    assert abs(shifts_of(seen(0.28 * X, 0.1 * X + 0.2 * Z, 48), X, sight * Y)[0]) < 1e-6
    assert abs(shifts_of(seen(0.1 * X + 0.2 * Z, 0.2 * X, 48), sight * Y, X)[1]) < 1e-6


def test_it_fades_as_the_arm_straightens():
    def forearm_px(bend_rad):
        upper = np.array([-np.cos(bend_rad), 0.0, np.sin(bend_rad)])
        return abs(shifts_of(seen(0.28 * X, 0.2 * upper, 48), X, upper)[0])

    clear, half = np.arcsin(CLEAR_BEND_SINE), np.arcsin(0.5 * CLEAR_BEND_SINE)
    assert forearm_px(1.5) == pytest.approx(forearm_px(clear), rel=1e-3)
    assert forearm_px(half) == pytest.approx(0.5 * forearm_px(clear), rel=1e-3)
    assert forearm_px(1e-4) < 0.01


def test_a_root_that_begins_down_the_arm_swings_farther_at_the_elbow():
    near, far = (shifts_of(seen(0.28 * X, 0.2 * Z, 48, share), X, Z)[0] for share in (0.0, 0.25))
    assert far == pytest.approx(near / 0.75)


@pytest.mark.parametrize("wrist_off", [(-0.19, -0.05, 0.19), (-0.22, 0.08, 0.12), (-0.10, -0.12, 0.22)])
def test_limbs_before_the_elbow_give_its_axis_back(wrist_off):
    matrices = exact_rig(StereoConfig()).matrices
    elbow = np.array([0.62, 0.42, 0.42])
    wrist, shoulder = elbow + wrist_off, elbow + np.array([0.20, -0.05, 0.14])
    forearm, upper_arm = unit(wrist - elbow), unit(shoulder - elbow)
    on_forearm = elbow - FOREARM_OFFSET_SHARE * 0.5 * THICK_M * behind(forearm, upper_arm)
    on_upper_arm = (0.5 * THICK_M - UPPER_ARM_DEPTH_M) * behind(upper_arm, forearm)
    features = []
    for matrix in matrices:
        width_px = THICK_M * FOCAL_PX / float(matrix[2, :3] @ elbow + matrix[2, 3])
        ends = (elbow - on_upper_arm, shoulder - on_upper_arm)
        features.append(view_of(matrix, on_forearm, wrist, *ends, width_px))
    joints = solve_joints(matrices, features, Body())
    assert joints is not None
    assert np.linalg.norm(joints.elbow - elbow) < 0.0015
    assert np.linalg.norm(joints.wrist - wrist) < 0.0015

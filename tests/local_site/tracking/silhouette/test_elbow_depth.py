"""Where in the limbs the elbow turns: what a camera beside, behind or anywhere sees of it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from local_site.calibration.triangulation import project
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking.features.features import Features
from local_site.tracking.features.medial import MedialLine, line_through
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.silhouette.joints import Body, solve_joints
from local_site.tracking.silhouette.limbs import (
    CLEAR_BEND_SINE,
    FOREARM_DEPTH_M,
    UPPER_ARM_DEPTH_M,
    behind,
    elbow_shifts,
    limbs_of,
    unit,
)
from tests.present import present

FOCAL_PX, DISTANCE_M = 800.0, 1.5
PX_PER_M = FOCAL_PX / DISTANCE_M
# Looks along y from DISTANCE_M before the origin; pixels run along x and against z.
CAMERA = np.array([[FOCAL_PX, 320.0, 0.0, 320 * DISTANCE_M], [0, 240, -FOCAL_PX, 240 * DISTANCE_M], [0, 1, 0, 1.5]])
ELBOW = np.zeros(3)
X, Y, Z = np.eye(3)
THICK_M = 0.09
BLANK = Silhouette(np.zeros((480, 640), np.uint8), 40.0, np.array([[300.0, 200.0], [310.0, 210.0]]))


def view_of(matrix, forearm_from, wrist, upper_from, shoulder, width_px):
    """The features of limbs as wide as that whose middles run between these points (3,)."""
    a, w, b, s = (project(matrix, p) for p in (forearm_from, wrist, upper_from, shoulder))
    forearm, upper_arm = present(line_through(a, w)), present(line_through(b, s))
    across = 0.5 * width_px * np.array([[-1.0], [1.0]])
    return Features(
        forearm=forearm,
        root=forearm,
        forearm_sides=a + across * forearm.normal,
        upper_arm=upper_arm,
        upper_arm_sides=b + across * upper_arm.normal,
        wrist=w,
        hand=None,
        half_width=0.5 * width_px,
        silhouette=BLANK,
        guess=Posture(s, a, w, w, 0.5 * width_px),
    )


def seen(wrist, shoulder, width_px):
    return view_of(CAMERA, ELBOW, wrist, ELBOW, shoulder, width_px)


def shifts_of(view, forearm, upper_arm):
    """Forearm's and upper arm's shift in px, seen by CAMERA, of limbs along unit vectors (3,)."""
    return elbow_shifts(limbs_of([CAMERA], [view])[0], ELBOW, forearm, upper_arm)


def towards(line, direction):
    """A line's normal (2,) on the side to which a direction (3,) points."""
    return math.copysign(1.0, along(line.normal, direction)) * line.normal


def along(line_normal, direction):
    """Pixels along a normal for each metre along a direction, at the elbow."""
    return float(line_normal @ (project(CAMERA, 1e-6 * direction) - project(CAMERA, ELBOW))) / 1e-6


def test_from_the_side_the_whole_offset_shows_towards_the_back():
    view = seen(0.28 * X, 0.2 * Z, THICK_M * PX_PER_M)
    forearm_px, upper_arm_px = shifts_of(view, X, Z)
    forearm_m = 0.5 * THICK_M - FOREARM_DEPTH_M
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


@pytest.mark.parametrize("bulge_px", [0.0, 9.0])
def test_flesh_on_the_inner_side_does_not_move_it(bulge_px):
    """The line in the middle of a limb goes with the flesh, the axis stays beneath the skin of the back."""
    view = seen(0.28 * X, 0.2 * Z, 48)
    shift = shifts_of(view, X, Z)[0]
    middle = MedialLine(view.root.point + bulge_px * towards(view.root, Z), view.root.direction)
    moved = shifts_of(replace(view, root=middle), X, Z)[0]
    axis, same = (float(line.normal @ line.point) + s for line, s in ((view.root, shift), (middle, moved)))
    assert same == pytest.approx(axis, abs=1e-3)


def test_where_the_back_is_not_seen_the_middle_stands():
    view = seen(0.28 * X, 0.2 * Z, 48)
    hidden = np.full((2, 2), np.nan)
    assert shifts_of(replace(view, forearm_sides=hidden, upper_arm_sides=hidden), X, Z) == (0.0, 0.0)


@pytest.mark.parametrize("wrist_off", [(-0.19, -0.05, 0.19), (-0.22, 0.08, 0.12), (-0.10, -0.12, 0.22)])
def test_limbs_before_the_elbow_give_its_axis_back(wrist_off):
    matrices = exact_rig(StereoConfig()).matrices
    elbow = np.array([0.62, 0.42, 0.42])
    wrist, shoulder = elbow + wrist_off, elbow + np.array([0.20, -0.05, 0.14])
    forearm, upper_arm = unit(wrist - elbow), unit(shoulder - elbow)
    on_forearm = elbow - (0.5 * THICK_M - FOREARM_DEPTH_M) * behind(forearm, upper_arm)
    on_upper_arm = (0.5 * THICK_M - UPPER_ARM_DEPTH_M) * behind(upper_arm, forearm)
    features = []
    for matrix in matrices:
        width_px = THICK_M * FOCAL_PX / float(matrix[2, :3] @ elbow + matrix[2, 3])
        ends = (elbow - on_upper_arm, shoulder - on_upper_arm)
        features.append(view_of(matrix, on_forearm, wrist, *ends, width_px))
    joints = solve_joints(limbs_of(matrices, features), features, Body())
    assert joints is not None
    assert np.linalg.norm(joints.elbow - elbow) < 0.0015
    assert np.linalg.norm(joints.wrist - wrist) < 0.0015

"""The monocular estimator's equations against finite differences."""

import numpy as np
import pytest

from common.geometry import rotation_from_vector
from local_site.tracking.monocular.arm_model import ArmPose
from local_site.tracking.monocular.equations import (
    ALL,
    LIGHT_SIGMA,
    LIGHTS,
    MOTION,
    UNKNOWNS,
    combined,
    condition,
    fill_observation,
    step,
    summed,
)

FOCAL, PRINCIPAL = np.array([655.0, 640.0]), np.array([100.0, 90.0])
NO_POSITION_ERROR = np.array([4.0, 0.0, 0.0, 0.0])


def pixel(point):
    return FOCAL * point[:2] / point[2] + PRINCIPAL


def moved(point, joint, motion):
    """Equation 1."""
    return rotation_from_vector(motion[3:]) @ (point - joint) + joint + motion[:3]


@pytest.mark.parametrize("unknown", range(6))
def test_a_row_is_the_slope_of_the_intensity_error(unknown):
    gradient, point, joint = np.array([3.0, -7.0]), np.array([0.11, -0.06, 1.3]), np.array([-0.02, 0.05, 1.36])
    row = np.empty(MOTION)
    fill_observation(row, gradient, FOCAL, point, point - joint)
    h = 1e-6 * np.eye(6)[unknown]
    shift = pixel(moved(point, joint, h)) - pixel(moved(point, joint, -h))
    assert row[unknown] == pytest.approx(-gradient @ shift / 2e-6, rel=1e-6, abs=1e-6)


@pytest.fixture
def scene():
    """A pose, surface points of both links, and a picture without curvature, which bilinear sampling gives exactly."""
    random = np.random.default_rng(5)
    y, x = np.mgrid[0:200, 0:260].astype(np.float64)
    grey, along_x, along_y = 40 + 0.3 * x + 0.2 * y + 0.002 * x * y, 0.3 + 0.002 * y, 0.2 + 0.002 * x
    level = (*(a.astype(np.float32) for a in (grey, along_x, along_y)), FOCAL, PRINCIPAL)
    turns = [rotation_from_vector(np.array(v)) for v in ((0.3, -0.2, 0.1), (-0.1, 0.2, 0.4))]
    pose = ArmPose(np.array([-0.02, -0.03, 1.3]), turns[0], turns[1], 0.1)
    points = random.uniform(-0.04, 0.04, (2, 300, 3)) + np.array([0.0, 0.0, 0.06])
    normals = points / np.linalg.norm(points, axis=2, keepdims=True)
    return level, pose, [(p, n, random.uniform(100, 140, 300)) for p, n in zip(points, normals, strict=True)]


def equations(scene, step_by=None):
    level, pose, surfaces = scene
    lights = (np.array([1.0, 0.0, 0.0, 0.0]),) * 2
    if step_by is not None:
        pose = pose.moved(step_by[:3], step_by[3:6], step_by[10:13])
        lights = lights[0] + step_by[6:10], lights[1] + step_by[13:17]
    links = [(*link, light) for link, light in zip(pose.links, lights, strict=True)]
    sums = [summed(s, link, level, NO_POSITION_ERROR, 1e9) for s, link in zip(surfaces, links, strict=True)]
    return combined(sums[0], sums[1], pose.elbow - pose.shoulder)


@pytest.mark.parametrize("unknown", range(UNKNOWNS))
def test_the_right_side_is_the_slope_of_the_mean_square(scene, unknown):
    h = 1e-5 * np.eye(UNKNOWNS)[unknown]
    squares = [float(e.points @ e.mean_square) for e in (equations(scene, h), equations(scene, -h))]
    slope = (squares[0] - squares[1]) / 2e-5
    # Half the slope, by the variance of 4 grey².
    right = equations(scene).right[unknown]
    assert -slope / 2 / 4.0 == pytest.approx(right, rel=1e-3)


def test_the_matrix_is_symmetric_and_couples_forearm_and_shoulder(scene):
    matrix = equations(scene).matrix
    np.testing.assert_allclose(matrix, matrix.T)
    scale = np.sqrt(np.diag(matrix))
    assert np.abs(matrix[:3, 10:13] / np.outer(scale[:3], scale[10:13])).max() > 0.05
    assert (np.diag(matrix)[LIGHTS] > 1.0 / LIGHT_SIGMA**2).all()


def test_a_step_without_a_solution_is_not_finite():
    none = combined(None, None, np.array([0.0, 0.0, 0.1]))
    assert np.isnan(step(none, ALL)).any()
    assert condition(np.diag([1.0, 4.0, 9.0])) == pytest.approx(1.0)

"""The operator's markers: bright discs exactly at their true centres, hidden by limbs that are in front of them."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from common.geometry import rotation_from_vector
from local_site.simulation.body import MARKER_RADIUS_M, ArmBody, MarkedArm
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import MotionConfig, PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.motion import Motion
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.rendering import Renderer

SHARP = PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0)
CONFIG = SimulationConfig(markers=True, picture=SHARP)


def bright(image):
    """Area (N,) and centroid (N, 2), both by coverage, of everything brighter than the glove."""
    _, labels = cv2.connectedComponents((image > 60).astype(np.uint8))
    coverage = np.clip((image - 35.0) / 200.0, 0.0, None)
    found = []
    for label in range(1, labels.max() + 1):
        rows, columns = np.nonzero(labels == label)
        weight = coverage[rows, columns]
        found.append((weight.sum(), np.array([columns @ weight, rows @ weight]) / weight.sum()))
    areas, centroids = zip(*found, strict=True)
    return np.array(areas), np.array(centroids)


@pytest.mark.parametrize("t_s", [0.0, 6.3, 9.0])
def test_three_bright_discs_are_where_the_truth_is(t_s):
    operator = SimulatedOperator(CONFIG)
    truth = operator.truth(t_s)
    for image, camera in zip(operator.render(t_s), stereo_pair(CONFIG.stereo), strict=True):
        areas, centroids = bright(image)
        assert len(areas) == 3
        for point in (truth.wrist, truth.index, truth.thumb):
            in_camera = camera.to_camera(point)
            apart = np.linalg.norm(centroids - camera.pixels(in_camera), axis=1)
            assert apart.min() < 0.1
            radius_px = CONFIG.stereo.focal_px * MARKER_RADIUS_M / in_camera[2]
            assert areas[np.argmin(apart)] == pytest.approx(np.pi * radius_px**2, rel=0.08)


def test_the_gloved_arm_is_dark_but_not_invisible():
    image = SimulatedOperator(CONFIG).render(0.0)[0]
    bare = SimulatedOperator(SimulationConfig(picture=SHARP)).render(0.0)[0]
    arm = cv2.erode((bare > 80).astype(np.uint8), np.ones((25, 25))) > 0
    assert 20 < image[arm].mean() < 60


def test_elbow_and_opening_are_those_of_the_bare_arm():
    marked, bare = SimulatedOperator(CONFIG), SimulatedOperator(SimulationConfig())
    for t_s in (0.0, 6.3):
        assert marked.truth(t_s).elbow == pytest.approx(bare.truth(t_s).elbow)
        assert marked.truth(t_s).hand_open == bare.truth(t_s).hand_open


def test_a_limb_in_front_hides_a_marker():
    pose = Motion(MotionConfig(), CONFIG.body, seed=1).pose(0.0)
    arm = MarkedArm(ArmBody(CONFIG.body))
    # The wrist's marker faces the cameras; half a turn about the forearm puts it behind the wrist.
    along = pose.operator_R_hand[:, 0]
    turned = replace(pose, operator_R_hand=rotation_from_vector(np.pi * along) @ pose.operator_R_hand)
    for camera in stereo_pair(CONFIG.stereo):
        renderer = Renderer(camera, arm.parts, StereoConfig(), SHARP, seed=1)
        shown, hidden = (
            renderer.render([arm.solid(p)])[tuple(np.rint(pixel(camera, arm.truth(p).wrist)).astype(int)[::-1])]
            for p in (pose, turned)
        )
        assert shown > 200
        assert hidden < 60


def pixel(camera, point):
    return camera.pixels(camera.to_camera(point))

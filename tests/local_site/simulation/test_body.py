"""The simulated arm's body: truth and skin agree, sizes are kept, postures are what they claim."""

import typing

import cv2
import numpy as np
import pytest

from local_site.kernels.filling import fill_hulls
from local_site.simulation.body import ArmBody
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import BodyConfig, MotionConfig, MotionName, SimulationConfig, StereoConfig
from local_site.simulation.motion import Motion
from local_site.simulation.rendering import part_hulls, project

THIN = BodyConfig(upper_arm_girth=0.25, elbow_girth=0.22, forearm_girth=0.225, wrist_girth=0.15, belly_offset=0.006)
MUSCULAR = BodyConfig(upper_arm_girth=0.36, elbow_girth=0.28, forearm_girth=0.32, wrist_girth=0.18, belly_offset=0.016)
TIMES_S = (0.0, 5.7, 7.1, 9.3, 11.5, 14.0)


def silhouettes(body, pose, stereo):
    masks = []
    for camera in stereo_pair(stereo):
        outlines = project(body.solid(pose), camera)
        mask = np.zeros((stereo.height_px, stereo.width_px), np.uint8)
        corners, ends = part_hulls(np.rint(16 * outlines.rims).astype(np.int32), body.parts)
        fill_hulls(mask, corners, ends, np.full(len(ends), 255, np.uint8), 4)
        masks.append(mask)
    return masks


def outline_distance(mask, pixel):
    """Signed distance in px from the outline, positive inside."""
    contour = max(cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0], key=len)
    return cv2.pointPolygonTest(contour, (float(pixel[0]), float(pixel[1])), True)


@pytest.mark.parametrize("config", [BodyConfig(), THIN, MUSCULAR], ids=["average", "thin", "muscular"])
@pytest.mark.parametrize("t_s", TIMES_S)
def test_joints_lie_deep_inside_the_silhouette_and_tips_at_its_edge(config, t_s):
    stereo = StereoConfig()
    pose = Motion(MotionConfig(), config, seed=1).pose(t_s)
    body = ArmBody(config)
    truth = body.truth(pose)
    cameras = stereo_pair(stereo)
    for mask, camera in zip(silhouettes(body, pose, stereo), cameras, strict=True):
        at = {
            name: camera.pixels(camera.to_camera(getattr(truth, name))) for name in ("elbow", "wrist", "index", "thumb")
        }
        assert outline_distance(mask, at["elbow"]) > 10
        assert outline_distance(mask, at["wrist"]) > 7
        # A tip on the skin may turn toward the camera or hide behind its neighbours, but never leaves the silhouette.
        assert outline_distance(mask, at["index"]) > -1.5
        assert outline_distance(mask, at["thumb"]) > -1.5


def test_tips_are_on_the_outline_of_the_initial_u_shape():
    stereo = StereoConfig()
    pose = Motion(MotionConfig(), BodyConfig(), seed=1).pose(0.0)
    body = ArmBody(BodyConfig())
    truth = body.truth(pose)
    for mask, camera in zip(silhouettes(body, pose, stereo), stereo_pair(stereo), strict=True):
        for tip in (truth.index, truth.thumb):
            assert abs(outline_distance(mask, camera.pixels(camera.to_camera(tip)))) < 3.0


@pytest.mark.parametrize("t_s", TIMES_S)
def test_limbs_keep_their_lengths(t_s):
    config = BodyConfig()
    pose = Motion(MotionConfig(tremor_mm=2.0), config, seed=3).pose(t_s)
    assert np.linalg.norm(pose.elbow - pose.shoulder) == pytest.approx(config.upper_arm_length)
    assert np.linalg.norm(pose.wrist - pose.elbow) == pytest.approx(config.forearm_length)
    assert pose.operator_R_hand.T @ pose.operator_R_hand == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(pose.operator_R_hand) == pytest.approx(1.0)


def test_the_u_shape_is_rigid_while_the_hand_turns():
    body = ArmBody(BodyConfig())
    motion = Motion(MotionConfig(name="rotate_z"), BodyConfig(), seed=1)
    triangles = []
    for t_s in (0.0, 4.0, 5.5, 7.0):
        truth = body.truth(motion.pose(t_s))
        points = np.array([truth.wrist, truth.index, truth.thumb])
        triangles.append(np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1))
    assert np.ptp(triangles, axis=0) == pytest.approx(np.zeros(3), abs=1e-12)


def test_more_girth_and_belly_make_a_wider_silhouette():
    stereo = StereoConfig()
    pose = Motion(MotionConfig(), BodyConfig(), seed=1).pose(0.0)
    areas = [
        np.count_nonzero(silhouettes(ArmBody(config), pose, stereo)[0]) for config in (THIN, BodyConfig(), MUSCULAR)
    ]
    assert areas[0] * 1.08 < areas[1] < areas[2] / 1.08


def fingers(mask):
    """How many separate fingers stand out: pieces that an opening wider than a finger removes."""
    palm = cv2.morphologyEx(mask, cv2.MORPH_OPEN, cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (13, 13)))
    count, _, stats, _ = cv2.connectedComponentsWithStats(cv2.subtract(mask, palm))
    return sum(stats[k, cv2.CC_STAT_AREA] > 60 for k in range(1, count))


def test_the_open_hand_shows_its_fingers_one_by_one():
    config = SimulationConfig(motion=MotionConfig(name="toggles"))
    pose = Motion(config.motion, config.body, seed=1).pose(2.9)
    counts = [fingers(mask) for mask in silhouettes(ArmBody(config.body), pose, config.stereo)]
    assert max(counts) >= 4


def test_the_u_shape_is_open_between_its_two_tips_in_both_views():
    stereo = StereoConfig()
    pose = Motion(MotionConfig(), BodyConfig(), seed=1).pose(0.0)
    body = ArmBody(BodyConfig())
    middle = 0.5 * (body.truth(pose).index + body.truth(pose).thumb)
    for mask, camera in zip(silhouettes(body, pose, stereo), stereo_pair(stereo), strict=True):
        assert outline_distance(mask, camera.pixels(camera.to_camera(middle))) < -5
        assert fingers(mask) <= 2


@pytest.mark.parametrize("name", typing.get_args(MotionName))
def test_the_arm_is_one_piece_and_within_the_picture_in_every_motion(name):
    config = SimulationConfig(motion=MotionConfig(name=name))
    motion, body = Motion(config.motion, config.body, seed=1), ArmBody(config.body)
    for t_s in np.arange(0.0, 15.0, 0.9):
        for mask in silhouettes(body, motion.pose(t_s), config.stereo):
            assert cv2.connectedComponents(mask)[0] == 2
            assert not mask[[0, -1]].any()
            assert not mask[:, [0, -1]].any()

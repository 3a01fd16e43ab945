"""The hand's postures: what a fist, a pointing and a flat hand are, and that its bones keep their lengths."""

import math

import numpy as np
import pytest

from local_site.simulation.body import ArmBody
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import BodyConfig, MotionConfig, StereoConfig
from local_site.simulation.hand import BONES, POSTURES, Hand
from local_site.simulation.motion import Motion

INDEX, MIDDLE, THUMB = 0, 1, 4


def bones(name, openness=0.0):
    """The bones (5, 3, 3) of a hand."""
    return np.diff(Hand(1.0, POSTURES[name]).joints(openness), axis=1)


def bend_deg(name, digit):
    """The angle between a digit's first bone and its last."""
    first, _, last = bones(name)[digit]
    return math.degrees(math.acos(first @ last / np.linalg.norm(first) / np.linalg.norm(last)))


@pytest.mark.parametrize("name", POSTURES)
@pytest.mark.parametrize("openness", [0.0, 0.4, 1.0])
def test_bones_keep_their_lengths(name, openness):
    assert np.linalg.norm(bones(name, openness), axis=2) == pytest.approx(BONES)


@pytest.mark.parametrize("name", POSTURES)
def test_backs_stand_upright_on_their_bones(name):
    backs = Hand(1.0, POSTURES[name]).backs(0.3)
    assert np.linalg.norm(backs, axis=2) == pytest.approx(np.ones((5, 3)))
    assert np.sum(backs * bones(name, 0.3), axis=2) == pytest.approx(np.zeros((5, 3)), abs=1e-12)


def test_every_posture_opens_to_the_same_hand():
    opened = [Hand(1.0, posture).balls(1.0) for posture in POSTURES.values()]
    for other in opened[1:]:
        assert other == pytest.approx(opened[0])


def test_a_fist_brings_all_tips_to_the_palm():
    tips = Hand(1.0, POSTURES["fist"]).joints(0.0)[:4, 3]
    assert tips[:, 0].max() < 0.09
    assert tips[:, 2].max() < -0.005


def test_pointing_stretches_the_index_only():
    tips = Hand(1.0, POSTURES["pointing"]).joints(0.0)[:, 3, 0]
    assert tips[INDEX] > 0.16
    assert max(*tips[1:4], tips[THUMB]) < 0.10
    assert bend_deg("pointing", INDEX) < 15
    assert bend_deg("pointing", MIDDLE) > 90


def test_a_flat_hand_is_straight_and_flat():
    assert max(bend_deg("flat", digit) for digit in range(4)) < 10
    assert np.ptp(Hand(1.0, POSTURES["flat"]).joints(0.0)[:4, :, 2]) < 0.02


@pytest.mark.parametrize(("roll_deg", "shows"), [(90.0, "palm"), (-90.0, "back")])
def test_rolling_turns_palm_or_back_to_the_cameras(roll_deg, shows):
    motion = Motion(MotionConfig(name="hold", posture="flat", roll_deg=roll_deg), BodyConfig(), seed=1)
    pose = motion.pose(0.0)
    for camera in stereo_pair(StereoConfig()):
        sight = (pose.wrist - camera.centre) / np.linalg.norm(pose.wrist - camera.centre)
        facing = float(pose.operator_R_hand[:, 2] @ sight)
        assert (facing > 0.5) if shows == "palm" else (facing < -0.5)


@pytest.mark.parametrize("name", POSTURES)
def test_the_truth_follows_the_posture(name):
    pose = Motion(MotionConfig(name="hold", posture=name), BodyConfig(), seed=1).pose(0.0)
    body = ArmBody(BodyConfig(), POSTURES[name])
    truth, joints = body.truth(pose), body.joints(pose)
    assert np.linalg.norm(truth.index - joints[INDEX, 3]) == pytest.approx(0.0068)
    assert np.linalg.norm(truth.thumb - joints[THUMB, 3]) == pytest.approx(0.0085)

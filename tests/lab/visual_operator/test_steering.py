"""The hand moves so that the arm, which follows it, comes to the goal; and stays in its room."""

import numpy as np
import pytest

from common.geometry import rotation_from_vector, transform, vector_from_rotation
from common.messages.hand import OperatorSettings
from lab.visual_operator.steering import LEAST, MOST, Movement, Steering, begin_of, within_room
from lab.visual_operator.task import PlacingTask
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.request_server import describe

CONFIG = RemoteConfig()
MAPPING = describe(CONFIG, *load_arm(CONFIG.robot)).mapping
BASE_R_OPERATOR = np.array(MAPPING.base_R_operator)
SETTINGS = OperatorSettings(lease=1, revision=1, scale=0.5, rotation_scale=0.25)
POSE = transform(PlacingTask().base_R_gripper, np.array([0.4, 0.1, 0.8]))


def followed(pose, gripper, movement):
    """The pose of what the gripper holds once the arm has followed: moved, and turned about the fingers."""
    shift = BASE_R_OPERATOR @ movement.shift * MAPPING.scale * SETTINGS.scale
    angle = BASE_R_OPERATOR @ vector_from_rotation(movement.turn) * SETTINGS.rotation_scale
    turn = rotation_from_vector(angle)
    fingers = gripper[:3, 3]
    return transform(turn @ pose[:3, :3], fingers + shift + turn @ (pose[:3, 3] - fingers))


def test_the_gripper_comes_to_its_goal():
    goal = transform(rotation_from_vector(np.array([0.1, -0.05, 0.2])) @ POSE[:3, :3], np.array([0.45, 0.0, 0.7]))
    movement = Steering(MAPPING, roll_locked=False).towards(goal, POSE, POSE, SETTINGS)
    assert followed(POSE, POSE, movement) == pytest.approx(goal, abs=1e-9)


def test_what_the_gripper_holds_comes_to_its_goal_though_the_arm_turns_about_the_fingers():
    block = transform(np.eye(3), np.array([0.48, 0.1, 0.75]))
    goal = transform(rotation_from_vector(np.array([0.0, 0.0, 0.4])), np.array([0.5, -0.1, 0.66]))
    movement = Steering(MAPPING, roll_locked=False).towards(goal, block, POSE, SETTINGS)
    assert followed(block, POSE, movement) == pytest.approx(goal, abs=1e-9)


def test_a_locked_roll_is_not_asked_for():
    roll = rotation_from_vector(0.2 * POSE[:3, 2]) @ POSE[:3, :3]
    movement = Steering(MAPPING, roll_locked=True).towards(transform(roll, POSE[:3, 3]), POSE, POSE, SETTINGS)
    assert movement.turn == pytest.approx(np.eye(3), abs=1e-9)


@pytest.mark.parametrize("shift", [(0.1, 0, 0), (-0.2, 0.1, 0.1), (0, 0, -0.5)])
def test_the_hand_never_leaves_its_room(shift):
    movement = Movement(np.array(shift), np.eye(3))
    begin = begin_of(movement.shift)
    for offset in (np.zeros(3), begin):
        possible = within_room(offset, np.eye(3), movement)
        if possible is not None:
            end = offset + possible.shift
            assert (end >= LEAST - 1e-9).all()
            assert (end <= MOST + 1e-9).all()
    assert within_room(begin, np.eye(3), movement) is not None


def test_with_no_room_or_turned_too_far_the_hand_is_brought_back_first():
    ahead = Movement(np.array([0.1, 0.0, 0.0]), np.eye(3))
    assert within_room(np.array([MOST[0], 0, 0]), np.eye(3), ahead) is None
    turned = Movement(np.zeros(3), rotation_from_vector(np.array([0.0, 0.0, 0.7])))
    assert within_room(np.zeros(3), np.eye(3), turned) is None


def test_who_does_not_see_a_turn_trusts_that_what_it_holds_turned_as_the_hand_did():
    steering = Steering(MAPPING, roll_locked=False, sees_turn=False)
    block = transform(np.eye(3), np.array([0.48, 0.1, 0.75]))
    goal = transform(rotation_from_vector(np.array([0.0, 0.0, 0.4])), np.array([0.5, -0.1, 0.66]))
    movement = steering.towards(goal, steering.believed(block, held=True), POSE, SETTINGS)
    steering.begin(movement, SETTINGS)
    askew = transform(rotation_from_vector(np.array([0.0, 0.0, 0.9])), goal[:3, 3])
    assert steering.believed(askew, held=True) == pytest.approx(goal, abs=1e-9)
    assert steering.believed(askew, held=False) is askew
    assert steering.believed(askew, held=True) == pytest.approx(askew)


def test_who_sees_it_believes_what_it_sees():
    steering = Steering(MAPPING, roll_locked=False)
    steering.believed(POSE, held=True)
    steering.begin(Movement(np.zeros(3), rotation_from_vector(np.array([0.0, 0.0, 0.4]))), SETTINGS)
    assert steering.believed(POSE, held=True) is POSE

"""The tool's target: from both origins, inside the box, then on the leash of the arm as sent and as measured."""

import dataclasses

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import rotation_from_vector
from common.messages.hand import OperatorSettings
from common.messages.robot import Pose
from remote_site.config import RemoteConfig
from remote_site.motion.config import ControlConfig
from remote_site.reasons import Code
from remote_site.session.samples import Accepted
from remote_site.teleop.config import MappingConfig
from remote_site.teleop.hold_offset import MOST_RAD
from remote_site.teleop.tool_target import ToolTarget
from tests.remote_site.remote_loop import arm, hand, workspace

MODEL, _ = arm()
START = RemoteConfig().robot.start
TURNED = START + 0.1 * np.eye(6)[0]
TOOL = MODEL.forward(START)
WRIST = np.array([0.0, 0.0, 0.3])
AS_GRANTED, RENEWED = OperatorSettings(), OperatorSettings(revision=1)
BORN, NOW = 10_000 * NS_PER_MS, 10_020 * NS_PER_MS


def sample(moved=(0.0, 0.0, 0.0), born_ns=BORN):
    """A sample of a hand that has moved by `moved` m in the robot's axes, and shows no orientation."""
    operator_R_base = np.array(MappingConfig().base_R_operator).T
    wrist = WRIST + operator_R_base @ np.array(moved)
    message = hand(1, born_ns, tuple(wrist.tolist()))
    return Accepted(message, wrist, None, born_ns, new_session=False, elbow=message.elbow)


def captured(q=START, leash_m=0.2):
    target = ToolTarget(MappingConfig(), ControlConfig(leash_m=leash_m), workspace(), MODEL, START)
    target.capture(sample(), AS_GRANTED, q, 3)
    return target


def test_capture_takes_the_tools_pose_and_names_the_engagement():
    target = captured(TURNED)
    assert (target.base_T_tool == MODEL.forward(TURNED)).all()
    assert target.engagement.number == 3
    assert target.engagement.hand_capture_ns == BORN
    assert target.engagement.base_T_tool == Pose.from_transform(MODEL.forward(TURNED))


def test_the_target_moves_as_the_hand_has_since_the_capture():
    target = captured()
    aimed = target.aim(sample((0.05, -0.03, 0.02)), AS_GRANTED, START, START, NOW)
    assert aimed.base_T_target[:3, 3] - TOOL[:3, 3] == pytest.approx([0.05, -0.03, 0.02])
    assert aimed.base_T_target[:3, :3] == pytest.approx(TOOL[:3, :3])
    assert aimed.base_T_target is target.base_T_tool
    assert (aimed.t_ns, aimed.now_ns, aimed.leashed) == (BORN, NOW, None)


def test_motion_before_the_capture_is_discarded():
    target = captured()
    moved = sample((0.05, -0.03, 0.02))
    target.aim(moved, AS_GRANTED, START, START, NOW)
    target.capture(moved, AS_GRANTED, START, 4)
    assert target.aim(moved, AS_GRANTED, START, START, NOW).base_T_target == pytest.approx(TOOL)


def test_the_leash_holds_the_target_near_the_measured_arm_wherever_it_was_captured():
    target = captured(leash_m=0.1)
    measured = MODEL.forward(TURNED)[:3, 3]
    aimed = target.aim(sample((0.0, -0.2, 0.0)), AS_GRANTED, TURNED, TURNED, NOW)
    assert aimed.leashed.code is Code.SATURATED
    assert np.linalg.norm(aimed.base_T_target[:3, 3] - measured) == pytest.approx(0.1)


def test_the_leash_holds_the_target_near_the_measured_arm_however_far_it_was_sent_ahead():
    target = captured(leash_m=0.1)
    for k in range(1, 60):
        q_sent = TURNED if k > 10 else START
        aimed = target.aim(sample((0.0, 0.005 * k, 0.0)), AS_GRANTED, q_sent, START, NOW)
    assert aimed.leashed.code is Code.SATURATED
    assert np.linalg.norm(aimed.base_T_target[:3, 3] - TOOL[:3, 3]) == pytest.approx(0.1, abs=1e-4)


def test_the_box_comes_before_the_leash():
    above = workspace().upper[2] - TOOL[2, 3]
    target = captured(leash_m=above + 0.01)
    aimed = target.aim(sample((0.0, 0.0, above + 0.5)), AS_GRANTED, START, START, NOW)
    assert aimed.leashed is None
    assert aimed.base_T_target[:3, 3] == pytest.approx([*TOOL[:2, 3], workspace().upper[2]])


def test_a_target_that_the_box_holds_is_told_with_how_far_the_hand_is_beyond_it():
    above = workspace().upper[2] - TOOL[2, 3]
    target = captured(leash_m=1.0)
    boxed = target.aim(sample((0.0, 0.0, above + 0.05)), AS_GRANTED, START, START, NOW).boxed
    assert boxed.code is Code.OUTSIDE_BOX
    assert "50 mm" in boxed.sentence
    assert target.aim(sample((0.0, 0.0, above + 0.001)), AS_GRANTED, START, START, NOW).boxed is None
    assert target.aim(sample((0.0, 0.0, above - 0.1)), AS_GRANTED, START, START, NOW).boxed is None


def test_new_origins_go_on_from_the_leashed_target():
    target, far, further = captured(leash_m=0.1), (0.0, 0.3, 0.0), (0.0, 0.3, -0.05)
    leashed = target.aim(sample(far), AS_GRANTED, START, START, NOW).base_T_target
    assert target.aim(sample(far), RENEWED, START, START, NOW).base_T_target == pytest.approx(leashed)
    moved = target.aim(sample(further), RENEWED, TURNED, TURNED, NOW).base_T_target
    assert moved[:3, 3] == pytest.approx(leashed[:3, 3] + [0.0, 0.0, -0.05])


def test_the_incremental_command_counts_from_the_tool_as_sent_whatever_is_read():
    target = ToolTarget(MappingConfig(command="incremental"), ControlConfig(), workspace(), MODEL, START)
    target.capture(sample(), AS_GRANTED, START, 1)
    for q_measured in (TURNED, START, START + 0.3 * np.eye(6)[2]):
        aimed = target.aim(sample((0.02, 0.0, 0.0)), AS_GRANTED, TURNED, q_measured, NOW)
        target.capture(sample(), AS_GRANTED, TURNED, 1)
        assert aimed.base_T_target[:3, 3] == pytest.approx(MODEL.forward(TURNED)[:3, 3] + [0.02, 0.0, 0.0])


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("off_rad", [-1.0, 0.5, 1.0])
def test_a_wrong_reading_moves_neither_a_target_nor_one_that_is_led(joint, off_rad):
    target, wrong = captured(), START + off_rad * np.eye(6)[joint]
    assert target.aim(sample(), AS_GRANTED, START, wrong, NOW).base_T_target == pytest.approx(TOOL)
    assert target.lead(TOOL, sample(), START, wrong, NOW).base_T_target == pytest.approx(TOOL)


def test_the_elbow_is_seen_from_the_wrist_in_the_bases_axes():
    aimed = captured().aim(sample(), AS_GRANTED, START, START, NOW)
    in_operator = np.array(sample().sample.elbow) - np.array(sample().sample.wrist)
    assert aimed.elbow == pytest.approx(np.array(MappingConfig().base_R_operator) @ in_operator)
    unsure = dataclasses.replace(sample(), elbow=None)
    assert captured().aim(unsure, AS_GRANTED, START, START, NOW).elbow is None


def test_new_origins_in_an_engagement_name_exactly_how_far_they_move_the_target():
    target = captured(leash_m=1.0)
    target.capture(sample((0.0, 0.09, 0.0)), AS_GRANTED, START, 3)
    assert target.engagement.shift_mm == pytest.approx(90.0)
    target.capture(sample((0.0, 0.03, 0.0)), AS_GRANTED, START, 4)
    assert (target.engagement.shift_mm, target.engagement.shift_deg) == (0.0, 0.0)


def test_new_origins_that_the_operator_clutched_for_name_no_shift():
    target = captured(leash_m=1.0)
    target.capture(sample((0.0, 0.09, 0.0)), AS_GRANTED, TURNED, 3, clutched=True)
    assert (target.engagement.shift_mm, target.engagement.shift_deg) == (0.0, 0.0)


def test_settings_that_came_while_the_tool_was_led_count_from_where_the_hand_takes_over():
    target, doubled = captured(leash_m=1.0), OperatorSettings(revision=1, scale=2.0)
    target.lead(TOOL, sample(), START, START, NOW)
    target.rebase(sample(), doubled)
    aimed = target.aim(sample((0.01, 0.0, 0.0)), doubled, START, START, NOW)
    assert aimed.base_T_target[:3, 3] - TOOL[:3, 3] == pytest.approx([0.02, 0.0, 0.0])


def test_a_hold_that_no_newer_sample_ends_gives_new_origins():
    target = captured()
    assert target.resume(sample(), AS_GRANTED, START, BORN) is False


def test_what_a_hold_has_left_to_make_up_does_not_move_a_target_that_was_led_meanwhile():
    target, moved = captured(), sample((0.02, 0.0, 0.0), BORN + 100 * NS_PER_MS)
    assert target.resume(moved, AS_GRANTED, START, BORN + 20 * NS_PER_MS)
    target.lead(TOOL, moved, START, START, NOW)
    target.rebase(moved, AS_GRANTED)
    assert target.aim(moved, AS_GRANTED, START, START, NOW).base_T_target == pytest.approx(TOOL)


@pytest.mark.parametrize(("way_m", "resumes"), [(0.03, True), (0.035, True), (0.045, False)])
def test_after_a_hold_the_hands_own_way_counts_however_it_is_scaled(way_m, resumes):
    """It began 20 ms after the last sample that was followed, and ends 80 ms later: four fifths of the way count."""
    target, half = captured(), OperatorSettings(scale=0.5)
    target.capture(sample(), half, START, 3)
    moved = sample((way_m, 0.0, 0.0), BORN + 100 * NS_PER_MS)
    assert target.resume(moved, half, START, BORN + 20 * NS_PER_MS) is resumes


@pytest.mark.parametrize(("share", "resumes"), [(0.9, True), (1.35, False)])
def test_after_a_hold_the_hands_own_turn_counts_however_it_is_scaled(share, resumes):
    target, half = captured(), OperatorSettings(rotation_scale=0.5)
    before = dataclasses.replace(sample(), operator_R_hand=np.eye(3))
    target.capture(before, half, START, 3)
    turn = rotation_from_vector(np.array([0.0, 0.0, share * MOST_RAD]))
    turned = dataclasses.replace(sample(born_ns=BORN + 100 * NS_PER_MS), operator_R_hand=turn)
    assert target.resume(turned, half, START, BORN + 20 * NS_PER_MS) is resumes

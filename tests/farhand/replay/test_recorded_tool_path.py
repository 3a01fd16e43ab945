"""The path of a recorded episode: the tool's targets while the arm followed, and the gripper's toggles."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.errors import RecordingError, RefusedError
from common.geometry import rotation_from_vector, transform
from common.messages.robot import Engagement, GripperCommand, Pose
from farhand.replay.recorded_scene import recorded_cell
from farhand.replay.recorded_tool_path import check_cell, path_of, recorded_path
from local_site.programmed.approach import SPEED_M_S
from tests.common.messages.golden_examples import STATE
from tests.farhand.replay.recorded_states import recorded_states

STEP_NS = 10_000_000
TOOL = transform(rotation_from_vector(np.array([0.1, 0.0, 0.3])), np.array([0.4, 0.1, 0.3]))


def stretch(begin_ns, count, x_m, number=1, toggles=0, gripper_next=GripperCommand.CLOSED):
    """States at 100 Hz with the target moving along x at 100 mm/s."""
    engagement = Engagement(number, number, Pose.from_transform(TOOL))
    return [
        replace(
            STATE,
            t_ns=begin_ns + k * STEP_NS,
            target=Pose.from_transform(TOOL + np.array([[0, 0, 0, x_m + 1e-3 * k], *[[0] * 4] * 3])),
            engagement=engagement,
            gripper_toggles_applied=toggles,
            gripper_next=gripper_next,
        )
        for k in range(count)
    ]


def test_targets_and_times_are_those_of_the_states():
    path = path_of(stretch(5_000, 201, 0.0))
    assert path.duration_s == pytest.approx(2.0)
    assert path.base_T_tool(1.0)[:3, 3] == pytest.approx(TOOL[:3, 3] + [0.1, 0, 0])
    assert path.base_T_tool(1.0)[:3, :3] == pytest.approx(TOOL[:3, :3])


def test_a_toggle_becomes_what_it_commanded_at_its_time():
    first, then = stretch(0, 101, 0.0), stretch(101 * STEP_NS, 100, 0.101, toggles=1, gripper_next=GripperCommand.OPEN)
    last = stretch(201 * STEP_NS, 50, 0.201, toggles=2)
    actions = path_of([*first, *then, *last]).actions
    assert [action.command for action in actions] == [GripperCommand.CLOSED, GripperCommand.OPEN]
    assert [action.t_s for action in actions] == pytest.approx([1.01, 2.01])


def test_a_pause_is_cut_out_and_what_the_arm_was_moved_meanwhile_is_crossed_slowly():
    path = path_of([*stretch(0, 101, 0.0), *stretch(60_000 * STEP_NS, 101, 0.5, number=2)])
    assert 0.4 / SPEED_M_S < path.duration_s - 2.0 < 20.0
    steps = np.linalg.norm(np.diff(path.positions, axis=0), axis=1) / np.diff(path.t_s)
    assert max(steps) < 0.11


def test_states_that_come_twice_or_late_are_left_out():
    states = stretch(0, 50, 0.0)
    assert path_of([*states, states[10], *stretch(50 * STEP_NS, 10, 0.05)]).duration_s == pytest.approx(0.59)


def test_an_episode_without_motion_and_one_that_is_not_there_are_refused_by_name(tmp_path):
    file = recorded_states(tmp_path).file
    cell = recorded_cell(file, tmp_path).cell
    with pytest.raises(RecordingError, match="no episode 7; it has episodes 1"):
        recorded_path(file, cell, 7)
    assert recorded_path(file, cell, None).episode == 1


def test_another_arm_is_refused(tmp_path):
    cell = recorded_cell(recorded_states(tmp_path).file, tmp_path)
    check_cell(cell, cell)
    with pytest.raises(RefusedError, match=r"this cell has a UR5"):
        check_cell(cell, replace(cell, robot="a UR5"))

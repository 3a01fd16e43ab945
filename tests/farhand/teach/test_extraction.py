"""A task from a path: the gripper's way points with their rests, the frame, and no hesitation."""

import numpy as np
import pytest

from common.errors import ConfigError
from common.messages.robot import GripperCommand
from farhand.commands.teach import extract, show
from farhand.replay.recorded_scene import recorded_cell
from farhand.teach.extraction import extracted, task_of
from farhand.teach.show import as_table, plotted
from farhand.teach.task_file import TaskOrigin, TaughtFrame, load_task
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory
from tests.farhand.replay.recorded_states import moves_back, recorded_states

ORIGIN = TaskOrigin(name="a task", robot="a465", tolerance_mm=1.0, tolerance_deg=1.0)


def path():
    """100 mm along x, a hesitation, 100 mm on, the gripper closes and the tool rests for 1.2 s, 100 mm up."""
    t_s = np.array([0.0, 1.0, 3.0, 4.0, 5.2, 6.2])
    x_m, z_m = np.array([0.0, 0.1, 0.1, 0.2, 0.2, 0.2]), np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.1])
    positions = np.column_stack([x_m, np.full(6, 0.3), z_m])
    orientations = np.tile([0.0, 0.0, 0.0, 1.0], (6, 1))
    return ToolTrajectory(t_s, positions, orientations, actions=(GripperAction(4.0, GripperCommand.CLOSED),))


def test_way_points_count_from_where_the_gripper_acts_first():
    task = task_of(path(), ORIGIN, None)
    assert task.frame.xyz_mm == pytest.approx((200.0, 300.0, 0.0))
    assert [point.xyz_mm for point in task.waypoints] == [
        pytest.approx(row, abs=1e-6) for row in [(-200.0, 0, 0), (0, 0, 0), (0, 0, 100.0)]
    ]
    closes = task.waypoints[1]
    assert closes.gripper == "closed"
    assert closes.dwell_s == pytest.approx(1.2, abs=0.03)
    assert task.waypoints[0].dwell_s == task.waypoints[2].dwell_s == 0.0


def test_another_frame_may_be_given():
    task = task_of(path(), ORIGIN, TaughtFrame(xyz_mm=(0.0, 300.0, 0.0), rpy_deg=(0.0, 0.0, 90.0)))
    assert task.waypoints[1].xyz_mm == pytest.approx((0.0, -200.0, 0.0), abs=1e-6)


def test_a_recording_becomes_a_file_that_is_shown(tmp_path, capsys):
    file, out, picture = recorded_states(tmp_path, moves_back).file, tmp_path / "task.toml", tmp_path / "task.png"
    extract(file, out)
    task = load_task(out)
    assert task.task.robot == recorded_cell(file, tmp_path).robot
    assert len(task.waypoints) == 2
    assert task.waypoints[1].xyz_mm[0] - task.waypoints[0].xyz_mm[0] == pytest.approx(-80.0, abs=2.0)
    show(out, picture)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert str(task.waypoints[1].xyz_mm[0])[:5] in capsys.readouterr().out
    with pytest.raises(ConfigError, match="exists already"):
        extract(file, out)


def test_the_table_and_the_picture_have_every_way_point():
    task = task_of(path(), ORIGIN, None)
    assert as_table(task).row_count == 3
    assert len(plotted(task).axes) == 3


def test_the_recordings_gripper_is_kept(tmp_path):
    file = recorded_states(tmp_path).file
    assert extracted(file, tmp_path, None, 2.0, 2.0).task.gripper_at_start == "closed"

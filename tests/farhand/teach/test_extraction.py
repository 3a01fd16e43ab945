"""A task from a path: the gripper's way points with their rests, the frame, and no hesitation."""

from itertools import combinations
from typing import Literal

import numpy as np
import pytest

from common.errors import ConfigError
from common.messages.robot import GripperCommand
from farhand.commands.teach import extract, show
from farhand.replay.recorded_scene import recorded_cell
from farhand.teach.extraction import extracted, task_of
from farhand.teach.show import as_table, plotted
from farhand.teach.task_file import TaskFile, TaskOrigin, TaughtFrame, WayPoint, load_task
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


@pytest.mark.slow
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
    assert "3 way points, 300 mm in" in str(as_table(task).caption)
    assert len(plotted(task).axes) == 3


def test_no_number_in_the_picture_covers_another_where_way_points_lie_close_together():
    crowd = [(40.0 + 3 * k % 7, 5.0 * (k % 2), 60.0) for k in range(20)]
    places = [(0.0, 0.0, 0.0), *crowd, (200.0, 100.0, 0.0)]
    grips: dict[int, Literal["open", "closed"]] = {5: "closed", 21: "open"}
    points = [WayPoint(xyz_mm=at, rotation_deg=(0.0, 0.0, 0.0), gripper=grips.get(k)) for k, at in enumerate(places)]
    figure = plotted(TaskFile(task=ORIGIN, waypoints=tuple(points)))
    for axes in figure.axes:
        named = {n for text in axes.texts for n in numbers(text.get_text().split("\n")[0])}
        assert named == set(range(1, len(points) + 1))
        assert sum("closed" in text.get_text() for text in axes.texts) == 1
        boxes = [text.get_window_extent() for text in axes.texts]
        assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


def numbers(label):
    """The numbers that '3–5, 9 closed' stands for."""
    for part in label.removesuffix(" closed").removesuffix(" open").split(", "):
        first, _, last = part.partition("–")
        yield from range(int(first), int(last or first) + 1)


@pytest.mark.slow
def test_the_recordings_gripper_is_kept(tmp_path):
    file = recorded_states(tmp_path).file
    assert extracted(file, tmp_path, None, 2.0, 2.0).task.gripper_at_start == "closed"


def test_each_action_of_a_recording_becomes_a_way_point_with_its_grip():
    t_s = np.arange(0.0, 8.0, 0.067)
    positions = np.column_stack([0.05 * t_s, np.full(len(t_s), 0.3), np.zeros(len(t_s))])
    turns = np.tile([0.0, 0.0, 0.0, 1.0], (len(t_s), 1))
    grips = [GripperCommand.CLOSED, GripperCommand.OPEN] * 9
    actions = tuple(GripperAction(float(t_s[6 * k + 6]), grip) for k, grip in enumerate(grips))
    task = task_of(ToolTrajectory(t_s, positions, turns, actions=actions), ORIGIN, None)
    assert [point.gripper for point in task.waypoints if point.gripper is not None] == ["closed", "open"] * 9

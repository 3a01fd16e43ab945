"""Way points to a path through time: within the speeds, the acceleration and the blend, at rest where it stops."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from common.errors import ConfigError
from common.geometry import angle_between
from common.messages.robot import GripperCommand
from farhand.teach.planning import BLEND_DEG, planned_path
from farhand.teach.task_file import TaskFile, TaskMotion, TaskOrigin, TaughtFrame, WayPoint

ORIGIN = TaskOrigin(name="a task", robot="a465")
# With two decimals, as a task file is written.
PLACE = st.tuples(*[st.integers(-20000, 20000).map(lambda value: value / 100)] * 3)
TURN = st.tuples(*[st.integers(-6000, 6000).map(lambda value: value / 100)] * 3)


def task_of(*points, **motion):
    return TaskFile(task=ORIGIN, waypoints=points, motion=TaskMotion(**motion))


def at(x, y, z, turn=(0.0, 0.0, 0.0), **more):
    return WayPoint(xyz_mm=(x, y, z), rotation_deg=turn, **more)


def speeds_mm_s(path):
    return 1e3 * np.linalg.norm(np.diff(path.positions, axis=0), axis=1) / np.diff(path.t_s)


def off_polyline_mm(path, task):
    """The greatest distance of the path from the straight ways between the way points."""
    corners = np.array([point.xyz_mm for point in task.waypoints])
    nearest = np.full(len(path.positions), np.inf)
    for begin, end in pairwise(corners):
        way = end - begin
        part = np.clip((1e3 * path.positions - begin) @ way / max(way @ way, 1e-12), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(1e3 * path.positions - begin - part[:, None] * way, axis=1))
    return nearest.max()


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(st.lists(st.tuples(PLACE, TURN), min_size=2, max_size=6))
def test_speeds_and_blend_are_kept_and_every_way_point_has_its_mark(points):
    assume(any(math.dist(place, points[0][0]) > 1.0 for place, _ in points))
    task = task_of(*(at(x, y, z, turn) for (x, y, z), turn in points))
    path = planned_path(task)
    assert max(speeds_mm_s(path)) <= 1.02 * task.motion.speed_mm_s
    turns = [
        angle_between(path.base_T_tool(t_s)[:3, :3], path.base_T_tool(t_s + 0.01)[:3, :3])
        for t_s in np.arange(0.0, path.duration_s - 0.01, 0.01)
    ]
    assert max(turns, default=0.0) <= 1.1 * math.radians(task.motion.turn_deg_s) * 0.01 + 1e-6
    assert off_polyline_mm(path, task) <= task.motion.blend_mm + 0.05
    assert len(path.marks) == len(points)
    assert list(path.marks) == sorted(path.marks)
    for ((x, y, z), turn), mark in zip(points, path.marks, strict=True):
        pose, wanted = path.base_T_tool(mark), at(x, y, z, turn).frame_T_tool
        assert 1e3 * np.linalg.norm(pose[:3, 3] - wanted[:3, 3]) <= task.motion.blend_mm + 1.0
        assert angle_between(pose[:3, :3], wanted[:3, :3]) <= math.radians(BLEND_DEG + 1.0)


def test_it_stands_where_the_gripper_acts_and_where_it_dwells():
    task = task_of(at(0, 0, 0), at(50, 0, 0, gripper="closed", dwell_s=0.4), at(100, 0, 0, dwell_s=0.5), at(150, 0, 0))
    path = planned_path(task)
    (action,) = path.actions
    assert (action.command, action.dwell_s, action.t_s) == (GripperCommand.CLOSED, 0.4, path.marks[1])
    for stop_s, moves_s in ((path.marks[1], 0.02), (path.marks[2], 0.5)):
        x_m = [path.base_T_tool(at_s)[0, 3] for at_s in (stop_s - 0.02, stop_s, stop_s + moves_s)]
        assert np.ptp(x_m) < 1e-4
    assert path.duration_s - path.marks[2] > 0.5 + 0.5


def test_a_gentle_corner_is_passed_and_a_sharp_one_or_one_without_blend_is_a_stop():
    gentle = (at(0, 0, 0), at(100, 0, 0), at(200, 60, 0))
    sharp = (at(0, 0, 0), at(100, 0, 0), at(20, 20, 0))
    for points, motion, passes in [(gentle, {}, True), (sharp, {}, False), (gentle, {"blend_mm": 0.0}, False)]:
        path = planned_path(task_of(*points, **motion))
        slowest = min(speeds_mm_s(path)[np.abs(path.t_s[1:] - path.marks[1]) < 0.05])
        assert bool(slowest > 20.0) is passes


def test_the_acceleration_is_limited_on_the_way_and_in_corners():
    path = planned_path(task_of(at(0, 0, 0), at(150, 0, 0), at(250, 80, 0), at(300, 200, 50)))
    t_s = np.arange(0.0, path.duration_s, 0.02)
    positions = np.array([path.base_T_tool(at_s)[:3, 3] for at_s in t_s])
    accelerations = np.linalg.norm(np.diff(positions, 2, axis=0), axis=1) / 0.02**2
    assert 1e3 * accelerations.max() < 1.5 * 400.0


def test_a_way_point_may_be_come_to_more_slowly():
    slow = planned_path(task_of(at(0, 0, 0), at(200, 0, 0, speed=0.2), at(400, 0, 0, speed=0.2)))
    assert max(speeds_mm_s(slow)) == pytest.approx(20.0, rel=0.02)


def test_another_frame_moves_and_turns_the_whole_path():
    task = task_of(at(0, 0, 0), at(100, 0, 0))
    turned = TaughtFrame(xyz_mm=(10.0, 20.0, 30.0), rpy_deg=(0.0, 0.0, 90.0))
    for path in (planned_path(task, turned.base_T_frame), planned_path(replace(task, frame=turned))):
        assert path.base_T_tool(path.duration_s)[:3, 3] == pytest.approx([0.01, 0.12, 0.03])


def test_a_task_without_a_way_and_one_in_other_units_is_refused():
    for points in [(at(1, 2, 3), at(1, 2, 3)), (at(0.31, 0.02, 0.4), at(0.42, 0.02, 0.1), at(0.42, 0.3, 0.4))]:
        with pytest.raises(ConfigError, match=r"at one place.*lengths are in mm"):
            planned_path(task_of(*points))


def test_a_turn_in_place_is_a_way():
    path = planned_path(task_of(at(0, 0, 0), at(0, 0, 0, (0.0, 0.0, 45.0))))
    assert path.duration_s > 1.0


def test_way_points_at_the_same_place_take_no_time():
    path = planned_path(task_of(at(0, 0, 0), at(0, 0, 0), at(100, 0, 0)))
    assert path.marks[0] == path.marks[1] == 0.0


@pytest.mark.parametrize("points", [(at(0, 0, 0), at(1e9, 0, 0)), (at(0, 0, 0), at(100, 0, 0, speed=1e-9))])
def test_a_task_that_would_take_for_ever_is_refused_before_it_takes_memory(points):
    with pytest.raises(ConfigError, match=r"is a way point far away.*or a speed too low"):
        planned_path(task_of(*points))

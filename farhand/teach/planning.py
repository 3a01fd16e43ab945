"""Way points to a path through time: straight, corners cut within the blend, jerk-limited between stops; pure."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from ruckig import InputParameter, Ruckig, Trajectory
from scipy.spatial.transform import Rotation

from common.errors import ConfigError
from common.geometry import Array, angle_between, rotation_from_vector, transform, vector_from_rotation
from farhand.teach.task_file import GRIPPER, TaskFile, TaskMotion, WayPoint
from local_site.programmed.tool_trajectory import GripperAction, ToolTrajectory

STEP_S = 0.01
LONGEST_S = 3600.0  # 360 000 poses
SAMPLES_PER_CORNER = 33  # odd, so that one is the way point
BLEND_DEG = 2.0  # by how much the orientation leaves that of a way point that is passed
SHARPEST_DEG = 110.0  # a sharper corner is a stop
SLOWEST_PASS = 0.3  # of the speed; a corner that has to be passed slower is a stop
SAME_S = 1e-6  # at full speed: two poses nearer than that are one
ONE_PLACE_M, ONE_PLACE_RAD = 1e-3, math.radians(1.0)
SHORTEST_M = 1e-4  # of a way that is passed without a stop
TINY = 1e-9


class _Stretch(NamedTuple):
    """The way from one stop to the next: poses (n, 4, 4), the times at full speed (n,), the greatest rate at corners.

    `marks` are the times at full speed of the way points after its first.
    """

    poses: Array
    full_s: Array
    rate: float
    marks: tuple[float, ...]


def planned_path(task: TaskFile, base_T_frame: Array | None = None) -> ToolTrajectory:
    """The task's path in the base frame; `base_T_frame` (4 x 4) takes the place of the taught frame.

    Between stops (ends, gripper, dwell, sharp corners) it obeys the speeds; speed, acceleration and jerk along it are
    limited, and a corner is left by at most the blend. ConfigError where all way points are at one place, to 1 mm and
    1 deg, or the task takes longer than LONGEST_S.
    """
    poses = way_points_in_base(task, base_T_frame)
    _check_way(poses)
    writer = _PathWriter(poses[0])
    writer.stop(task.waypoints[0])
    begin = 0
    for end in _stops(poses, task):
        stretch = _stretch(poses[begin : end + 1], task.waypoints[begin : end + 1], task.motion)
        writer.move(stretch, task.motion)
        writer.stop(task.waypoints[end])
        begin = end
    return writer.path()


def way_points_in_base(task: TaskFile, base_T_frame: Array | None = None) -> list[Array]:
    """The poses (4 x 4) of the way points in the base frame; `base_T_frame` takes the place of the taught frame."""
    base_T_frame = task.frame.base_T_frame if base_T_frame is None else base_T_frame
    return [base_T_frame @ point.frame_T_tool for point in task.waypoints]


def _check_way(poses: Sequence[Array]) -> None:
    first = poses[0]
    ways = (float(np.linalg.norm(pose[:3, 3] - first[:3, 3])) for pose in poses)
    turns = (angle_between(first[:3, :3], pose[:3, :3]) for pose in poses)
    if max(ways) < ONE_PLACE_M and max(turns) < ONE_PLACE_RAD:
        raise ConfigError(
            "all way points of the task are at one place, to 1 mm and 1 deg: there is no way to run; "
            "lengths are in mm, angles in deg"
        )


class _Corner(NamedTuple):
    """A way point that is passed: rounded from how far before it on, at which part of the speed; 0 for a stop."""

    reach_m: float
    rate: float


class _PathWriter:
    """Puts stretches and stops one after the other."""

    def __init__(self, base_T_first: Array) -> None:
        self._t_s, self._poses = [0.0], [base_T_first]
        self._marks, self._actions = [0.0], list[GripperAction]()

    def stop(self, point: WayPoint) -> None:
        """The gripper acts, and the tool stands."""
        if point.gripper is not None:
            self._actions.append(GripperAction(self._t_s[-1], GRIPPER[point.gripper], point.dwell_s))
        elif point.dwell_s > 0.0:
            self._t_s.append(self._t_s[-1] + point.dwell_s)
            self._poses.append(self._poses[-1])

    def move(self, stretch: _Stretch, motion: TaskMotion) -> None:
        """Along a stretch from rest to rest."""
        begin_s, length_s = self._t_s[-1], float(stretch.full_s[-1])
        if length_s < SAME_S:
            self._marks += [begin_s] * len(stretch.marks)
            return
        if begin_s + length_s / stretch.rate > LONGEST_S:
            cure = "is a way point far away (xyz_mm, frame), or a speed too low?"
            raise ConfigError(f"the task takes longer than {LONGEST_S:.0f} s: {cure}")
        profile = _profile(length_s, stretch.rate, motion)
        t_s = np.linspace(0.0, profile.duration, math.ceil(profile.duration / STEP_S) + 1)[1:]
        full_s = np.array([profile.at_time(at_s)[0][0] for at_s in t_s])
        self._t_s += (begin_s + t_s).tolist()
        self._poses += _poses_at(stretch, full_s)
        self._marks += [begin_s + float(np.interp(mark, full_s, t_s)) for mark in stretch.marks]

    def path(self) -> ToolTrajectory:
        """Return the path that has been put together."""
        poses = np.array(self._poses)
        orientations = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
        return ToolTrajectory(
            np.array(self._t_s), poses[:, :3, 3], orientations, tuple(self._marks), tuple(self._actions)
        )


def _stops(poses: Sequence[Array], task: TaskFile) -> list[int]:
    """The way points after the first at which the tool stands."""
    points, last = task.waypoints, len(poses) - 1
    between = [k for k in range(1, last) if points[k].stands or _corner(poses, points, k, task.motion).rate == 0.0]
    return [*between, last]


def _corner(poses: Sequence[Array], points: Sequence[WayPoint], k: int, motion: TaskMotion) -> _Corner:
    """Compute how a way point between two others is passed: by the middle of a quadratic Bezier curve, bent most."""
    before, after = poses[k][:3, 3] - poses[k - 1][:3, 3], poses[k + 1][:3, 3] - poses[k][:3, 3]
    longer = float(np.linalg.norm(before)), float(np.linalg.norm(after))
    if min(longer) < SHORTEST_M:
        return _Corner(0.0, 0.0)  # the tool turns in place before or after it
    angle = math.acos(float(np.clip(before @ after / math.prod(longer), -1.0, 1.0)))
    turns = (_turn(poses[k], poses[k + 1]) / longer[1], _turn(poses[k - 1], poses[k]) / longer[0])
    reach_m = min(
        2e-3 * motion.blend_mm / max(math.sin(angle / 2), TINY),
        4.0 * math.radians(BLEND_DEG) / max(float(np.linalg.norm(turns[0] - turns[1])), TINY),
        0.5 * min(longer),
    )
    if angle > math.radians(SHARPEST_DEG) or reach_m < SHORTEST_M:
        return _Corner(0.0, 0.0)
    bent = math.sin(angle / 2) / (reach_m * math.cos(angle / 2) ** 2)
    speed_m_s = 1e-3 * motion.speed_mm_s * max(points[k].speed, points[k + 1].speed)
    rate = math.sqrt(1e-3 * motion.acceleration_mm_s2 / max(bent, TINY)) / speed_m_s
    return _Corner(reach_m, min(rate, 1.0) if rate > SLOWEST_PASS else 0.0)


def _stretch(poses: Sequence[Array], points: Sequence[WayPoint], motion: TaskMotion) -> _Stretch:
    """The way through way points of which only the ends are stops."""
    bent, speeds, at, rate = [poses[0]], list[float](), list[int](), 1.0
    for k in range(1, len(poses) - 1):
        corner = _corner(poses, points, k, motion)
        curve = _curve(poses[k - 1], poses[k], poses[k + 1], corner.reach_m)
        half = len(curve) // 2
        at.append(len(bent) + half)
        bent += curve
        speeds += [points[k].speed] * (half + 1) + [points[k + 1].speed] * half
        rate = min(rate, corner.rate)
    at.append(len(bent))
    bent.append(poses[-1])
    speeds.append(points[-1].speed)
    full_s = _full_s(bent, np.array(speeds), motion)
    return _Stretch(np.array(bent), full_s, rate, tuple(full_s[at].tolist()))


def _curve(before: Array, corner: Array, after: Array, reach_m: float) -> list[Array]:
    """The poses of a corner that is rounded from `reach_m` before it on."""
    begin = _between(corner, before, reach_m / float(np.linalg.norm(before[:3, 3] - corner[:3, 3])))
    end = _between(corner, after, reach_m / float(np.linalg.norm(after[:3, 3] - corner[:3, 3])))
    parts = np.linspace(0.0, 1.0, SAMPLES_PER_CORNER)
    return [_between(_between(begin, corner, part), _between(corner, end, part), part) for part in parts]


def _between(begin: Array, end: Array, part: float) -> Array:
    """A pose a part of the way from one to another."""
    position = begin[:3, 3] + part * (end[:3, 3] - begin[:3, 3])
    return transform(rotation_from_vector(part * _turn(begin, end)) @ begin[:3, :3], position)


def _turn(begin: Array, end: Array) -> Array:
    """The turn from one orientation to another, as a rotation vector (3,) in the base's axes, rad."""
    return vector_from_rotation(end[:3, :3] @ begin[:3, :3].T)


def _full_s(poses: Sequence[Array], speeds: Array, motion: TaskMotion) -> Array:
    """Compute when each pose is reached at full speed, from 0 on; `speeds` (n - 1,) are the fractions in between."""
    ways = [float(np.linalg.norm(b[:3, 3] - a[:3, 3])) / (1e-3 * motion.speed_mm_s) for a, b in pairwise(poses)]
    turns = [angle_between(a[:3, :3], b[:3, :3]) / math.radians(motion.turn_deg_s) for a, b in pairwise(poses)]
    return np.concatenate([[0.0], np.cumsum(np.maximum(ways, turns) / speeds)])


def _profile(full_s: float, rate: float, motion: TaskMotion) -> Trajectory:
    """From rest to rest over `full_s` seconds at full speed, at most at `rate` of it; acceleration, jerk limited."""
    asked = InputParameter(1)
    asked.current_position, asked.target_position = [0.0], [full_s]
    asked.max_velocity = [rate]
    asked.max_acceleration = [motion.acceleration_mm_s2 / motion.speed_mm_s]
    asked.max_jerk = [motion.jerk_mm_s3 / motion.speed_mm_s]
    found = Trajectory(1)
    Ruckig(1).calculate(asked, found)
    return found


def _poses_at(stretch: _Stretch, full_s: Array) -> list[Array]:
    """The poses of a stretch at these times at full speed."""
    kept = np.concatenate([[True], np.diff(stretch.full_s) > 0.0])
    times, poses = stretch.full_s[kept], stretch.poses[kept]
    orientations = Rotation.from_matrix(poses[:, :3, :3]).as_quat()
    along = ToolTrajectory(times, poses[:, :3, 3], orientations)
    return [along.base_T_tool(at_s) for at_s in full_s.tolist()]

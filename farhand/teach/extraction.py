"""A task from one recorded episode: its path reduced to way points, with the gripper's actions and rests."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from common.geometry import Array, angle_between, inverse, transform
from common.messages.robot import GripperCommand
from farhand.replay.recorded_scene import recorded_cell
from farhand.replay.recorded_tool_path import recorded_path
from farhand.teach.task_file import Grip, TaskFile, TaskOrigin, TaughtFrame, WayPoint, rows_of
from local_site.programmed.tool_trajectory import ToolTrajectory

STEP_S = 0.02
REST_M_S, REST_RAD_S = 0.01, np.radians(5.0)
LONGEST_DWELL_S = 2.0
GRIPS: dict[GripperCommand, Grip] = {GripperCommand.OPEN: "open", GripperCommand.CLOSED: "closed"}


def reduced(poses: Array, keep: Sequence[int], tolerance_m: float, tolerance_rad: float) -> list[int]:
    """The indices of the poses (n, 4, 4) that are left, the ends and those to `keep` among them.

    Between two of them the position goes straight, the orientation turns about one axis, both in proportion to the way
    that the path has come; Ramer-Douglas-Peucker on both distances, each as a part of its tolerance.
    """
    fixed = sorted({0, len(poses) - 1, *keep})
    way = _way(poses, tolerance_m, tolerance_rad)
    left = set(fixed)
    waiting = list(pairwise(fixed))
    while waiting:
        begin, end = waiting.pop()
        if end - begin < 2:
            continue
        apart = _apart(poses[begin : end + 1], way[begin : end + 1], tolerance_m, tolerance_rad)
        worst = begin + int(np.argmax(apart))
        if apart[worst - begin] > 1.0:
            left.add(worst)
            waiting += [(begin, worst), (worst, end)]
    return sorted(left)


def _way(poses: Array, tolerance_m: float, tolerance_rad: float) -> Array:
    """Compute how far the path has come at each pose, in tolerances."""
    moved = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1) / tolerance_m
    orientations = Rotation.from_matrix(poses[:, :3, :3])
    turned = (orientations[:-1].inv() * orientations[1:]).magnitude() / tolerance_rad
    return np.concatenate([[0.0], np.cumsum(moved + turned)])


def _apart(poses: Array, way: Array, tolerance_m: float, tolerance_rad: float) -> Array:
    """Compute how far each pose is from the straight way between the first and the last, in tolerances."""
    length = way[-1] - way[0]
    part = (way - way[0]) / length if length > 0.0 else np.zeros(len(way))
    straight = poses[0, :3, 3] + part[:, None] * (poses[-1, :3, 3] - poses[0, :3, 3])
    off_m = np.linalg.norm(poses[:, :3, 3] - straight, axis=1)
    orientations = Rotation.from_matrix(poses[:, :3, :3])
    turn = (orientations[0].inv() * orientations[-1]).as_rotvec()
    off_rad = ((orientations[0] * Rotation.from_rotvec(part[:, None] * turn)).inv() * orientations).magnitude()
    apart: Array = np.maximum(off_m / tolerance_m, off_rad / tolerance_rad)
    return apart


def extracted(
    file: Path,
    folder: Path,
    episode: int | None,
    tolerance_mm: float,
    tolerance_deg: float,
    frame: TaughtFrame | None = None,
) -> TaskFile:
    """The task of an episode, the only one where none is given; `folder` is for files of the moment.

    The frame stands where the gripper acts first, else where the path begins, with the base's axes, unless it is given.
    RecordingError as `recorded_path`.
    """
    cell = recorded_cell(file, folder)
    recorded = recorded_path(file, cell.cell, episode)
    origin = TaskOrigin(
        name=f"episode {recorded.episode} of {file.stem}",
        robot=cell.robot,
        recorded=f"{file.name}, episode {recorded.episode}",
        gripper_at_start=GRIPS[recorded.gripper_at_start] if recorded.gripper_at_start is not None else None,
        tolerance_mm=tolerance_mm,
        tolerance_deg=tolerance_deg,
    )
    return task_of(recorded.path, origin, frame)


def task_of(path: ToolTrajectory, origin: TaskOrigin, frame: TaughtFrame | None) -> TaskFile:
    """The task of a path; a person's hesitation is not part of it, a rest where the gripper acts is."""
    acted_s = [action.t_s for action in path.actions]
    t_s = np.unique([*np.arange(0.0, path.duration_s, STEP_S), *acted_s, path.duration_s])
    poses = np.array([path.base_T_tool(at_s) for at_s in t_s])
    acts = {int(np.searchsorted(t_s, action.t_s)): GRIPS[action.command] for action in path.actions}
    kept = reduced(poses, sorted(acts), 1e-3 * origin.tolerance_mm, float(np.radians(origin.tolerance_deg)))
    frame = frame or TaughtFrame(xyz_mm=rows_of(transform(np.eye(3), poses[min(acts, default=0)][:3, 3]))[0])
    frame_T_base = inverse(frame.base_T_frame)
    points = []
    for k in kept:
        xyz_mm, rotation_deg = rows_of(frame_T_base @ poses[k])
        dwell_s = _rest_s(t_s, poses, k) if k in acts else 0.0
        points.append(WayPoint(xyz_mm=xyz_mm, rotation_deg=rotation_deg, gripper=acts.get(k), dwell_s=dwell_s))
    return TaskFile(task=origin, frame=frame, waypoints=tuple(points))


def _rest_s(t_s: Array, poses: Array, begin: int) -> float:
    """Measure how long the tool rests from a pose on, s, at most two."""
    k = begin
    while k + 1 < len(poses) and t_s[k + 1] - t_s[begin] < LONGEST_DWELL_S and _rests(t_s, poses, k):
        k += 1
    return round(float(t_s[k] - t_s[begin]), 2)


def _rests(t_s: Array, poses: Array, k: int) -> bool:
    elapsed_s = t_s[k + 1] - t_s[k]
    way = float(np.linalg.norm(poses[k + 1][:3, 3] - poses[k][:3, 3]))
    turn = angle_between(poses[k][:3, :3], poses[k + 1][:3, :3])
    return bool(way < REST_M_S * elapsed_s and turn < REST_RAD_S * elapsed_s)

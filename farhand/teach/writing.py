"""A task as the text that a person edits: TOML with units and comments."""

from collections.abc import Iterator

from common.text import toml_string
from farhand.teach.task_file import TaskFile, WayPoint
from remote_site.assist.placement import Row3

HEAD = """\
# A taught task: edit it by hand, look at it with 'farhand teach show', run it with 'farhand teach run'.
# Lengths are in mm, angles in deg, times in s.
"""
FRAME = """\
# Where the way points count from, in the base frame; rpy_deg turns it about the base's x, then y, then z axis. After a
# fixture was moved, only this has to be taught anew.
"""
MOTION = """\
# How the tool moves. It stops where the gripper acts or it dwells, at sharp corners, and at both ends; others are
# cut by at most blend_mm (0: it stops at each).
"""
POINTS = """\
# The way points, in order: the tool centre point, and the axes of the tool, by the axis in the frame times the angle.
# Optional: gripper = "open" or "closed" and dwell_s, once the tool stands there; speed, a
# fraction of the speeds above on the way to it.
"""


def as_toml(task: TaskFile) -> str:
    """The text of a task file."""
    return "\n".join([*_head(task), *(line for k, point in enumerate(task.waypoints, 1) for line in _point(k, point))])


def _head(task: TaskFile) -> Iterator[str]:
    origin, frame, motion = task.task, task.frame, task.motion
    yield HEAD
    yield "[task]"
    yield f"name = {toml_string(origin.name)}  # as the operator's page shows it"
    yield f"robot = {toml_string(origin.robot)}  # no other runs it"
    yield f"recorded = {toml_string(origin.recorded)}"
    if origin.gripper_at_start is not None:
        yield f"gripper_at_start = {toml_string(origin.gripper_at_start)}  # has to be so before it is run"
    yield f"tolerance_mm = {origin.tolerance_mm:g}  # how far the way points leave the recorded path"
    yield f"tolerance_deg = {origin.tolerance_deg:g}\n"
    yield f"{FRAME}[frame]"
    yield f"xyz_mm = {_row(frame.xyz_mm)}"
    yield f"rpy_deg = {_row(frame.rpy_deg)}\n"
    yield f"{MOTION}[motion]"
    for name in motion.__struct_fields__:
        yield f"{name} = {getattr(motion, name):g}"
    yield f"\n{POINTS}"


def _point(number: int, point: WayPoint) -> Iterator[str]:
    yield f"[[waypoints]]  # {number}"
    yield f"xyz_mm = {_row(point.xyz_mm)}"
    yield f"rotation_deg = {_row(point.rotation_deg)}"
    if point.gripper is not None:
        yield f"gripper = {toml_string(point.gripper)}"
    if point.dwell_s > 0.0:
        yield f"dwell_s = {point.dwell_s:g}"
    if point.speed != 1.0:
        yield f"speed = {point.speed:g}"
    yield ""


def _row(values: Row3) -> str:
    return f"[{', '.join(f'{value + 0.0:.2f}' for value in values)}]"

"""The task file: way points of the tool relative to a taught frame, read and checked; units are in the names."""

import math
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
from msgspec import Meta, field

from common.config.loading import load_config
from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from common.messages.robot import GripperCommand
from remote_site.assist.placement import Row3, transform_of

Grip = Literal["open", "closed"]
GRIPPER: dict[Grip, GripperCommand] = {"open": GripperCommand.OPEN, "closed": GripperCommand.CLOSED}
LONGEST_REST_S = 60.0


class TaughtFrame(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The frame of the way points, in the robot's base frame; turned about its x, then y, then z."""

    xyz_mm: Annotated[Row3, Meta(description="its origin, mm")] = (0.0, 0.0, 0.0)
    rpy_deg: Annotated[Row3, Meta(description="its axes, deg")] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        _check_finite(self.xyz_mm, self.rpy_deg)

    @property
    def base_T_frame(self) -> Array:
        """Its pose (4 x 4) in the base frame."""
        return transform_of(self.xyz_mm, self.rpy_deg)


class WayPoint(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A pose of the tool in the taught frame, what the gripper does there, and how fast it is come to."""

    xyz_mm: Annotated[Row3, Meta(description="the tool centre point, mm")]
    rotation_deg: Annotated[Row3, Meta(description="the tool's axes, by the axis in the frame times the angle, deg")]
    gripper: Annotated[Grip | None, Meta(description="open or closed, once the tool stands there")] = None
    dwell_s: Annotated[float, Meta(ge=0, le=LONGEST_REST_S, description="how long it stands there, s")] = 0.0
    speed: Annotated[float, Meta(gt=0, le=1, description="on the way to it, as a fraction of [motion]")] = 1.0

    def __post_init__(self) -> None:
        _check_finite(self.xyz_mm, self.rotation_deg)

    @property
    def stands(self) -> bool:
        """Return whether the tool stops there."""
        return self.gripper is not None or self.dwell_s > 0.0

    @property
    def frame_T_tool(self) -> Array:
        """The tool's pose (4 x 4) in the taught frame."""
        rotation = rotation_from_vector(np.radians(self.rotation_deg))
        return transform(rotation, 1e-3 * np.array(self.xyz_mm))


class TaskMotion(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The motion of the tool from way point to way point."""

    speed_mm_s: Annotated[float, Meta(ge=1, le=500, description="of the tool, mm/s")] = 100.0
    turn_deg_s: Annotated[float, Meta(ge=1, le=180, description="of the tool's axes, deg/s")] = 45.0
    acceleration_mm_s2: Annotated[float, Meta(ge=10, le=5000, description="mm/s²")] = 400.0
    jerk_mm_s3: Annotated[float, Meta(ge=100, le=50000, description="mm/s³")] = 4000.0
    blend_mm: Annotated[float, Meta(ge=0, le=50, description="how far a corner may be cut; 0 stops at each, mm")] = 3.0


class TaskOrigin(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The task's name and origin."""

    name: Annotated[str, Meta(max_length=100, description="as the operator's page shows it")]
    robot: Annotated[str, Meta(max_length=100, description="the robot that it was taught on; no other runs it")]
    recorded: Annotated[str, Meta(max_length=200, description="the recording and its episode")] = ""
    gripper_at_start: Annotated[Grip | None, Meta(description="how the gripper has to be before")] = None
    tolerance_mm: Annotated[float, Meta(ge=0, description="how far way points leave the recorded path, mm")] = 0.0
    tolerance_deg: Annotated[float, Meta(ge=0, description="the same of the tool's axes, deg")] = 0.0


class TaskFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A taught task."""

    task: TaskOrigin
    waypoints: Annotated[tuple[WayPoint, ...], Meta(min_length=2, max_length=2000)]
    frame: TaughtFrame = field(default_factory=TaughtFrame)
    motion: TaskMotion = field(default_factory=TaskMotion)


def load_task(path: Path) -> TaskFile:
    """The task of a file; ConfigError with everything that is wrong in it, a line each."""
    return load_config(TaskFile, path)


def rows_of(pose: Array) -> tuple[Row3, Row3]:
    """Its position in mm, and its rotation as axis times angle in deg."""
    x, y, z = (1e3 * pose[:3, 3]).tolist()
    rx, ry, rz = np.degrees(vector_from_rotation(pose[:3, :3])).tolist()
    return (x, y, z), (rx, ry, rz)


def _check_finite(*rows: Row3) -> None:
    if not all(math.isfinite(value) for row in rows for value in row):
        raise ValueError("lengths and angles must be finite numbers")

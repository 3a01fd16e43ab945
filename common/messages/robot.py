"""The robot's state as the remote site publishes it; frozen structs."""

from enum import StrEnum
from typing import Annotated, Self

import msgspec

from common.geometry import Array, quaternion_from_rotation
from common.messages.base import Count, Joints, Message, Name, Quaternion, Text, Vector3
from common.messages.hand import ClockSync


class SessionState(StrEnum):
    """The state of the session at the remote site."""

    DISENGAGED = "disengaged"
    ENGAGED = "engaged"
    HOLDING = "holding"
    FAULT = "fault"


class GripperStatus(StrEnum):
    """How far the gripper has executed its last command; `holding` is stopped by an object."""

    MOVING = "moving"
    OPEN = "open"
    CLOSED = "closed"
    HOLDING = "holding"
    TIMED_OUT = "timed_out"


class Pose(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A pose in the robot's base frame: position in m, orientation as a unit quaternion (x, y, z, w)."""

    position: Vector3
    orientation: Quaternion

    @classmethod
    def from_transform(cls, base_T_frame: Array) -> Self:
        """The pose that a rigid transform (4 x 4) describes."""
        x, y, z = base_T_frame[:3, 3].tolist()
        qx, qy, qz, qw = quaternion_from_rotation(base_T_frame[:3, :3]).tolist()
        return cls((x, y, z), (qx, qy, qz, qw))


class GripperState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The gripper as measured: opening between the fingers in m, grip force in N, None where it is not measured.

    `commanded_open` is the last command, `status` its progress.
    """

    opening: float
    force: float | None
    commanded_open: bool
    status: GripperStatus


class Obeyed(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The hand sample that the robot obeys, and when its first command was written and reached the robot."""

    session: Count
    seq: Count
    capture_ns: Count
    command_ns: Count
    motion_ns: Count | None


class Traced(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A hand sample followed to the robot's encoders: its exposure, its first command, when that reached the robot.

    `encoder_ns` is when the measured joints were first as far as that command, along its motion. All but the exposure
    are by the remote site's clock.
    """

    session: Count
    seq: Count
    capture_ns: Count
    command_ns: Count
    motion_ns: Count
    encoder_ns: Count


class Engagement(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One engagement: its number since the remote site started, and the origins captured at its last reference."""

    number: Count
    hand_capture_ns: Count
    base_T_tool: Pose


class LeaseState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Who may operate: the lease's number, its holder, its end by the remote clock, and who asks for it."""

    number: Count
    holder: Name
    session: Count
    expires_ns: Count
    asked_by: Name | None


class Readiness(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Whether the arm could be engaged now; the sentence states what is missing. `held`: key or pedal is held."""

    ready: bool
    code: Name
    reason: Text
    held: bool


class LoopTiming(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The timing of the control loop since it started."""

    hz: float
    late_p99_us: float
    missed: Count
    ticks: Count
    real_time: bool


class RobotState(Message, frozen=True):
    """The robot and its session at one instant, as measured and as commanded.

    `q` and `q_commanded` are in the order of `joints` (rad); `code` and `reason` explain its state.
    `rejected` counts refused hand samples by reason since the remote site started. `clock` is from the newest sample of
    the lease's holder. `target` is the target pose of the tool, inside box and leash, None unless the
    arm follows. `min_distance` is the least distance between parts of the arm, and between them and the cell's
    fixtures, m; None where nothing is configured that could be touched. `traced` is the newest sample that the encoders
    have shown.
    """

    session: Count
    seq: Count
    t_ns: Count
    state: SessionState
    code: Name
    reason: Text
    joints: Annotated[tuple[Name, ...], msgspec.Meta(max_length=16)]
    q: Joints
    q_commanded: Joints
    base_T_tool: Pose
    gripper: GripperState | None
    gripper_toggles_applied: Count
    obeyed: Obeyed | None
    engagement: Engagement | None
    rejected: Annotated[dict[Name, Count], msgspec.Meta(max_length=64)]
    timing: LoopTiming
    lease: LeaseState | None
    clock: ClockSync | None
    readiness: Readiness
    min_distance: float | None = None
    target: Pose | None = None
    traced: Traced | None = None

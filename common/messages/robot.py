"""The robot's state as the remote site publishes it; frozen structs."""

from enum import StrEnum
from typing import Annotated, Self

import msgspec
import numpy as np

from common.geometry import Array, quaternion_from_rotation, rotation_from_quaternion, transform
from common.messages.base import Count, Joints, Message, Name, Quaternion, Text, Vector3
from common.messages.hand import ClockSync, OperatorSettings
from common.messages.recording import RecordingState


class SessionState(StrEnum):
    """The state of the session at the remote site."""

    DISENGAGED = "disengaged"
    ENGAGED = "engaged"
    HOLDING = "holding"
    FAULT = "fault"


FOLLOWING = (SessionState.ENGAGED, SessionState.HOLDING)  # within an engagement
STOPPED = "stopped"  # the code after a stop, until it is reset
SITE_ENDED = "site_ended"  # the code of the last state of a remote site that was asked to end
NO_PAGE = (  # a console with a page that operates says instead what is late
    "no page operates: open the operator's page and take the controls; to operate without a page, "
    "release the lease and take it again"
)


class GripperCommand(StrEnum):
    """What the gripper is commanded to do; `keep` leaves it as it is, whatever it holds."""

    OPEN = "open"
    CLOSED = "closed"
    KEEP = "keep"


class GripperStatus(StrEnum):
    """How far the gripper has executed its last command; `holding` is stopped by an object.

    `unknown` is a gripper at rest of which its measurements do not show whether it holds something.
    """

    MOVING = "moving"
    OPEN = "open"
    CLOSED = "closed"
    HOLDING = "holding"
    TIMED_OUT = "timed_out"
    UNKNOWN = "unknown"


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

    def transform(self) -> Array:
        """The rigid transform (4 x 4) from the frame to the base's."""
        return transform(rotation_from_quaternion(self.orientation), np.array(self.position))


class GripperState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The gripper as measured: opening between the fingers in m, grip force in N, None where it is not measured.

    `commanded` is the command in force, `status` its progress; with `keep` it is judged by the measurements.
    """

    opening: float
    force: float | None
    commanded: GripperCommand
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
    """One engagement: its number since the remote site started, and the origins captured at its last reference.

    `shift_mm` and `shift_deg` are how far new origins after a hold moved the target; 0 where it has only these, and
    after a clutch, which is to move it.
    """

    number: Count
    hand_capture_ns: Count
    base_T_tool: Pose
    shift_mm: float = 0.0
    shift_deg: float = 0.0


class RotationReference(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """From where the hand's rotation turns the tool.

    The target had the orientation `base_R_tool` when the hand had `operator_R_hand` (None while it shows none). `turn`
    is the hand's rotation since, as a rotation vector in the base's axes, rad, unscaled; it may exceed half a turn.
    Locked rotations count from `base_R_locked`, None without any.
    """

    operator_R_hand: Quaternion | None
    base_R_tool: Quaternion
    turn: Vector3
    base_R_locked: Quaternion | None


class MappingReference(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The reference of the tool's targets, after that of one hand sample: from it later targets can be computed.

    `session` and `seq` name the sample; `revision` is that of the settings under which it counts. `offset` is where the
    target would be for a hand at the operator frame's origin, m in the base's frame, outside the box too.
    """

    session: Count
    seq: Count
    revision: Count
    offset: Vector3
    rotation: RotationReference


def site_words(name: str, session: int) -> str:
    """An operator at a local site, as people read it: two hosts may operate under one name."""
    return f"{name} (site {session:x})"


class Asker(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Who asks for the lease: the operator's name, and the session of that local site."""

    name: Name
    session: Count

    def __str__(self) -> str:
        return site_words(self.name, self.session)


class LeaseState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Who may operate: the lease's number, its holder, its end by the remote clock, and who asks for it."""

    number: Count
    holder: Name
    session: Count
    expires_ns: Count
    asked_by: Asker | None

    def __str__(self) -> str:
        return site_words(self.holder, self.session)


class Readiness(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The arm's readiness to be engaged now; the sentence states what is missing. `held`: key or pedal is held."""

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


class HandLink(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The way of the hand samples over the last seconds, as measured where they arrive; times in ms.

    `age_ms` is the age at arrival that one sample in twenty exceeds, and the sum of that sample's parts: the network
    (one way, by the clocks' offset), the offset's uncertainty, and capture to sending, none of it while the arm is
    still being learned. All four are None while the offset is not known. Samples arrive `interval_ms` apart (median);
    `jitter_ms` is the mean change of the time in the network from one sample to the next (RFC 3550, section 6.4.1, not
    smoothed), `loss` the fraction of samples that never came. `code` and `reason` state what is wrong and its cure;
    both are empty while nothing is.
    """

    age_ms: float | None
    network_ms: float | None
    clock_ms: float | None
    tracking_ms: float | None
    interval_ms: float
    jitter_ms: float
    loss: float
    code: Text = ""
    reason: Text = ""


class VideoTrouble(StrEnum):
    """Who is too slow for the pictures."""

    NARROW = "narrow"
    SLOW_PAGE = "slow_page"
    BUSY_HOST = "busy_host"


class VideoLink(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The reason why pictures are late or missing: what is carried, what all would need, and why, with its cure."""

    carries_mbit_s: float
    needs_mbit_s: float
    reason: Text
    code: VideoTrouble = VideoTrouble.NARROW


class AssistPhase(StrEnum):
    """The phase of fine adjustment: whether the robot adjusts the tool's pose by itself, or offers to."""

    OFF = "off"
    OFFERED = "offered"
    LEADING = "leading"
    ENDED = "ended"


class AssistTarget(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A target of fine adjustment: its marker of side `size` in m, and the tool's pose there.

    The tool is `distance_mm` and `angle_deg` away from it; `views` are the cameras that the marker's pose is from.
    """

    name: Name
    kind: Name
    base_T_marker: Pose
    size: float
    base_T_tool: Pose
    distance_mm: float
    angle_deg: float
    views: Annotated[tuple[Name, ...], msgspec.Meta(max_length=16)]


class AssistState(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The state of fine adjustment: what it offers or does, or why neither; `target` is None without a known marker."""

    phase: AssistPhase
    code: Name
    reason: Text
    target: AssistTarget | None


class RobotState(Message, frozen=True):
    """The robot and its session at one instant, as measured and as commanded.

    `q` and `q_commanded` are in the order of the description's joints (rad); `code` and `reason` explain its state.
    `rejected` counts refused hand samples by reason since the remote site started. `clock` is from the newest sample of
    the lease's holder. `target` is the target pose of the tool, inside box and leash, None unless the
    arm follows. `min_distance` is the least distance between parts of the arm, and between them and the cell's
    fixtures, m; None where nothing is configured that could be touched. `traced` is the newest sample that the encoders
    have shown. `age_limit_ms` is the age up to which samples are obeyed, `speed_scale` the fraction of full speed that
    it leaves. `gripper_next` is what the next toggle would command, `open` or `closed`; `settings` are the operator's
    in force, None without a lease. `reference` is what the targets count from: None unless the arm follows, and where
    each target begins at the tool. `hand_link` is None before the holder's samples come; `video_link` is None
    while the link carries all pictures, or nobody watches them. `assist` is None where no targets are configured,
    `recording` where no recorder runs. `halted_ns` is when the newest halt came, a stop, a fault, a disengagement or a
    robot that stopped by itself, by the remote clock: a reset or an engagement names it. It is 0 before the first.
    """

    session: Count
    seq: Count
    t_ns: Count
    state: SessionState
    code: Name
    reason: Text
    age_limit_ms: float
    speed_scale: float
    q: Joints
    q_commanded: Joints
    base_T_tool: Pose
    gripper: GripperState | None
    gripper_toggles_applied: Count
    gripper_next: GripperCommand
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
    settings: OperatorSettings | None = None
    reference: MappingReference | None = None
    hand_link: HandLink | None = None
    video_link: VideoLink | None = None
    assist: AssistState | None = None
    recording: RecordingState | None = None
    halted_ns: Count = 0

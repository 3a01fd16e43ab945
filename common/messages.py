"""The wire messages: frozen structs, SI units, times in monotonic nanoseconds of the sender."""

from enum import StrEnum
from typing import Annotated

import msgspec

PROTOCOL_VERSION = 7

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Text = Annotated[str, msgspec.Meta(max_length=400)]
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=64)]
Count = Annotated[int, msgspec.Meta(ge=0, le=2**63 - 1)]
Difference = Annotated[int, msgspec.Meta(ge=-(2**63), le=2**63 - 1)]
Variance = Annotated[float, msgspec.Meta(ge=0)]
Covariance = tuple[Variance, float, float, Variance, float, Variance]
Joints = Annotated[tuple[float, ...], msgspec.Meta(max_length=16)]


class TrackingStatus(StrEnum):
    """How far a hand sample can be trusted."""

    INITIALISING = "initialising"
    TRACKED = "tracked"
    DEGRADED = "degraded"
    LOST = "lost"


class SessionState(StrEnum):
    """The state of the session at the remote site."""

    DISENGAGED = "disengaged"
    ENGAGED = "engaged"
    HOLDING = "holding"
    FAULT = "fault"


class GripperStatus(StrEnum):
    """How far the gripper has come with what it was told; `holding` is closed short, on an object."""

    MOVING = "moving"
    OPEN = "open"
    CLOSED = "closed"
    HOLDING = "holding"
    TIMED_OUT = "timed_out"


class CameraStatus(StrEnum):
    """Whether a camera's picture shows the cell as it is now."""

    LIVE = "live"
    DARK = "dark"
    SLOW = "slow"
    FROZEN = "frozen"
    MISSING = "missing"


class Message(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Base of all messages: every one carries the protocol version."""

    version: int = PROTOCOL_VERSION


class PointCovariances(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How sure each point is: its covariance xx, xy, xz, yy, yz, zz in m² in the operator frame, None where unknown."""

    elbow: Covariance | None = None
    wrist: Covariance | None = None
    index: Covariance | None = None
    thumb: Covariance | None = None
    palm: Covariance | None = None


class Locks(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Motions that the operator does not want copied: along the base's axes, and about the tool's."""

    x: bool = False
    y: bool = False
    z: bool = False
    roll: bool = False
    pitch: bool = False
    yaw: bool = False


class Intent(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """What the operator wants; the defaults mean that nothing is held and nothing is asked for.

    `hold` is the hold-to-run key or pedal. `clutch_count` rises by one each time the operator takes new origins; the
    scales multiply what the remote site has configured.
    """

    hold: bool = False
    clutch_count: Count = 0
    scale: Annotated[float, msgspec.Meta(ge=0.01, le=5)] = 1.0
    rotation_scale: Annotated[float, msgspec.Meta(ge=0, le=2)] = 1.0
    locks: Locks = Locks()


class OperatorIntent(Message, frozen=True):
    """The intent as a console or pedal tells it to the local site on its own host, at 20 Hz or more."""

    sent_ns: Count
    intent: Intent


class ClockSync(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The remote site's clock minus the local site's, as the local site measured it over the control session, ns.

    `measured_ns` is by the remote site's clock, so that it can tell how old the measurement is.
    """

    remote_minus_local_ns: Difference
    uncertainty_ns: Count
    measured_ns: Count


class HandArm(Message, frozen=True):
    """One tracked instant of the operator's arm.

    Points are absolute in the operator frame (the calibration plate's), m, None where they could not be measured; the
    palm is a point of the hand as a rigid extension of the forearm, from the tracker of one camera alone.
    `covariance` is of the single measurement, before any smoothing; None from a sender that does not know it.
    `session` is a random number chosen at each start of the local site, `seq` rises by one each sample,
    `gripper_toggles` counts the openings of the hand since the session began. `lease` is the number under which the
    remote site lets this operator work, 0 without one; `clock` is None while the offset is not known.
    """

    session: Count
    seq: Count
    capture_ns: Count
    elbow: Vector3 | None
    wrist: Vector3 | None
    index: Vector3 | None
    thumb: Vector3 | None
    status: TrackingStatus
    reason: Text
    thumb_inferred: bool
    hand_open: bool
    gripper_toggles: Count
    palm: Vector3 | None = None
    covariance: PointCovariances | None = None
    lease: Count = 0
    clock: ClockSync | None = None
    intent: Intent = Intent()


class Pose(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A pose in the robot's base frame: position in m, orientation as a unit quaternion (x, y, z, w)."""

    position: Vector3
    orientation: Quaternion


class GripperState(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The gripper as measured: opening between the fingers in m, grip force in N, None where it is not measured.

    `commanded_open` is the last command, `status` what has become of it.
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
    """Who may operate: the lease's number, its holder, until when by the remote clock, and who asks for it."""

    number: Count
    holder: Name
    session: Count
    expires_ns: Count
    asked_by: Name | None


class Readiness(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Whether the arm could be engaged now, and what the operator wants; the sentence says what is missing."""

    ready: bool
    code: Name
    reason: Text
    held: bool


class LoopTiming(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How well the control loop keeps its pace since it started."""

    hz: float
    late_p99_us: float
    missed: Count
    ticks: Count
    real_time: bool


class RobotState(Message, frozen=True):
    """The robot and its session at one instant, as measured and as commanded.

    `q` and `q_commanded` are in the order of `joints` (rad); `code` and `reason` say why the robot does what it does.
    `rejected` counts refused hand samples by reason since the remote site started. `clock` is what the newest sample of
    the lease's holder said of the clocks. `target` is where the hand wants the tool, inside box and leash, None unless
    the arm follows. `min_distance` is the least between parts of the arm, and between them and
    the cell's fixtures, in m; None where nothing is known that could be touched. `traced` is the newest sample that the
    encoders have shown.
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


class VideoFrame(Message, frozen=True):
    """One camera picture, or the word that there is none: `jpeg` is empty where `status` is frozen or missing.

    A dark or slow camera's pictures are sent too; `reason` says what is the matter with it.
    """

    camera: Name
    seq: Count
    capture_ns: Count
    capture_estimated: bool
    status: CameraStatus
    reason: Text
    width: Annotated[int, msgspec.Meta(ge=0, le=8192)]
    height: Annotated[int, msgspec.Meta(ge=0, le=8192)]
    jpeg: bytes


class ViewCame(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest picture of one camera that has come to the console's host, how old it was then, how many come."""

    seq: Count
    age_ms: Annotated[float, msgspec.Meta(ge=0)]
    fps: Annotated[float, msgspec.Meta(ge=0)]


class ViewShown(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The newest picture of one camera that a console has painted, how old it was then, and how many it paints.

    `came` tells the link's share of that from the page's.
    """

    seq: Count
    capture_ns: Count
    age_ms: Annotated[float, msgspec.Meta(ge=0)]
    fps: Annotated[float, msgspec.Meta(ge=0)]
    came: ViewCame


class ViewsShown(Message, frozen=True):
    """What the operator's console shows, at 10 Hz, so that the remote site sends as much as arrives in time.

    `session` is a random number chosen at each start of the console, `lease` the number of its operator's lease, 0
    without one.
    """

    session: Count
    sent_ns: Count
    lease: Count
    views: Annotated[dict[Name, ViewShown], msgspec.Meta(max_length=16)]

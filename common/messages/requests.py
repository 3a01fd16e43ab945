"""Requests that must take effect once, questions that may be asked again, and their answers."""

from enum import StrEnum
from typing import Annotated

import msgspec

from common.messages.base import MOST_JOINTS, Count, Difference, Message, Name, Text, Vector3
from common.messages.hand import HandPoint, Locks
from common.messages.recording import EpisodeOutcome
from common.messages.robot import Asker, Pose
from common.messages.shapes import ShapesDescription

WAITING = "waiting"  # the code where the local site keeps asking for the lease that another holds
SILENT = "silent"  # the code where a site that was asked does not answer
NO_RECORDER = "no_recorder"  # the code of a site beside which no recorder runs
Fraction = Annotated[float, msgspec.Meta(ge=0, le=1)]
PicturePoint = tuple[Fraction, Fraction]


class Request(Message, frozen=True):
    """A message that must act once: repeated with the same `id`, refused after `deadline_ns` by the server's time."""

    id: Count
    deadline_ns: Count


class Reply(Message, frozen=True):
    """The answer to a request: done or refused, with code and sentence."""

    id: Count
    done: bool
    code: Name
    reason: Text


class EngagementAction(StrEnum):
    """The action on the engagement; a stop bars the next one until it is reset."""

    ENGAGE = "engage"
    DISENGAGE = "disengage"
    STOP = "stop"
    RESET = "reset"


class EngagementRequest(Request, frozen=True):
    """Engage, disengage or reset the arm: for the lease's holder, by the name in the key on which the request comes.

    `seen_ns` is `RobotState.halted_ns` as its sender was shown it; an engagement or a reset is refused where another
    halt has come since. A disengagement needs none.
    """

    action: EngagementAction
    seen_ns: Count = 0

    def __post_init__(self) -> None:
        if self.action is EngagementAction.STOP:
            raise ValueError("a stop is a StopRequest")


class StopRequest(Message, frozen=True):
    """Stop the arm: anybody may, and it is carried out whenever it comes, so that it needs no clock and no deadline.

    Its reply has the id 0.
    """


class LeaseAction(StrEnum):
    """A local site's action on the remote site's lease."""

    ACQUIRE = "acquire"
    RENEW = "renew"
    RELEASE = "release"
    HAND_OVER = "hand_over"


class LeaseRequest(Request, frozen=True):
    """A local site, identified by its session and the name in the key, and the lease that it holds (0 without one).

    `to` is whom the holder has seen asking when consenting to a handover; it is void for anybody else.
    """

    action: LeaseAction
    session: Count
    lease: Count
    to: Asker | None = None


class LeaseReply(Reply, frozen=True):
    """The reply to a LeaseRequest: `lease` is the client's own, 0 without one.

    `holder`, at the site of the session `holder_session`, holds the cell's lease for `lasts_ns` more; it is empty while
    nobody does.
    """

    lease: Count = 0
    lasts_ns: Count = 0
    holder: Text = ""
    holder_session: Count = 0


class OperatorAction(StrEnum):
    """An operator's request of the local site: ask for the lease, hand it over to another operator, release it."""

    TAKE = "take"
    GIVE = "give"
    RELEASE = "release"


class OperatorRequest(Request, frozen=True):
    """An explicit act of the operator, sent to the local site; `to` is who was shown to ask for the lease given."""

    action: OperatorAction
    to: Asker | None = None


class JointsRequest(Request, frozen=True):
    """The positions of the joints that an operator has clicked in the picture of the one camera that is tracked.

    Each is a fraction of the picture's width, from the left, and of its height, from the top.
    """

    shoulder: PicturePoint
    elbow: PicturePoint
    wrist: PicturePoint


class RecordAction(StrEnum):
    """The action on a recording: begin or end it; begin or end an episode; say how an episode went."""

    START = "start"
    STOP = "stop"
    BEGIN = "begin"
    END = "end"
    LABEL = "label"


class RecordRequest(Request, frozen=True):
    """A request of the lease's holder to a recorder, of the remote site or of their own local one.

    `task` is of the episodes from now on, unless it is empty. `outcome` and `note` are of the episode that is under
    way, or else of the last one; UNKNOWN and an empty note change nothing.
    """

    action: RecordAction
    task: Text = ""
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN
    note: Text = ""


class ClockQuestion(Message, frozen=True):
    """The question for the time at the remote site."""


class ClockAnswer(Message, frozen=True):
    """The times at which the question was received and answered, by the remote site's clock.

    `ahead_ns` is by how much that host's steady time was ahead of the clock then (`common/steady_time.py`).
    """

    received_ns: Count
    answered_ns: Count
    ahead_ns: Difference = 0


class TroubleReport(Message, frozen=True):
    """A problem with the link that an operator's site found, for the remote site's log."""

    reason: Text


class TroubleNoted(Message, frozen=True):
    """The answer to a TroubleReport: the remote site has noted it."""


class DescribeQuestion(Message, frozen=True):
    """The question for the description of this cell."""


class JointDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One joint with the limits in force, rad and rad/s (m and m/s where it slides).

    `parent_T_joint` is its frame in the one before it, in the base's for the first; it turns about, or slides along,
    `axis` of its own frame.
    """

    name: Name
    lower: float
    upper: float
    speed: float
    parent_T_joint: Pose
    axis: Vector3
    slides: bool


class ViewCalibration(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A camera's 3 x 4 projection matrix, row by row, from m to pixels of the full picture.

    It projects points of the base's frame, or of the tool's where the camera is mounted on the tool (`on_tool`); pixels
    count from the picture's upper left corner.
    """

    projection: Annotated[tuple[float, ...], msgspec.Meta(min_length=12, max_length=12)]
    on_tool: bool


class CameraDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One camera of the cell, as configured; most are not calibrated."""

    name: Name
    width: Count
    height: Count
    fps: float
    calibration: ViewCalibration | None = None


class MappingDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The mapping of the hand's motion to the tool's, as configured.

    The tool copies the `point` of the hand, `scale` times; with what the operator sets, the product stays within
    `scale_range`. `base_R_operator` is row by row; `locks` are the motions that are never copied.
    """

    point: HandPoint
    scale: float
    scale_range: tuple[float, float]
    base_R_operator: tuple[Vector3, Vector3, Vector3]
    locks: Locks


class Description(Message, frozen=True):
    """The cell: its software, its robot with joints, limits and shapes, its cameras, and its rates in Hz.

    `held`: the arm follows only while the operator holds key or pedal (hold-to-run). `last_T_tool` is the tool centre
    point in the last joint's frame; the workspace is a box in the base's frame, m.
    """

    cell: Name
    software: Name
    robot: Text
    driver: Name
    joints: Annotated[tuple[JointDescription, ...], msgspec.Meta(max_length=MOST_JOINTS)]
    cameras: Annotated[tuple[CameraDescription, ...], msgspec.Meta(max_length=16)]
    held: bool
    control_hz: float
    last_T_tool: Pose
    workspace_min: Vector3
    workspace_max: Vector3
    mapping: MappingDescription
    shapes: ShapesDescription

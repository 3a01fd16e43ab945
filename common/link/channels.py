"""The one table of channels and procedures: key, messages, roles, session, priority, rate, staleness, size."""

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, Generic, TypeVar

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import ConfigError, MessageError
from common.link.roles import CELL_NAME, EVERYBODY, MAINTAINERS, OPERATORS, OTHERS, REMOTES, Role
from common.messages.base import Message
from common.messages.hand import HandArm, OperatorIntent
from common.messages.probe import MOST_PADDING, ROOM_BYTES, Probe, ProbeEcho
from common.messages.recording import RecordingNotice
from common.messages.requests import (
    ClockAnswer,
    ClockQuestion,
    DescribeQuestion,
    Description,
    EngagementRequest,
    JointsRequest,
    LeaseReply,
    LeaseRequest,
    OperatorRequest,
    RecordRequest,
    Reply,
    StopRequest,
    TroubleNoted,
    TroubleReport,
)
from common.messages.robot import RobotState
from common.messages.video import KeyFrameRequest, VideoFrame, ViewsShown

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
RATE_MARGIN = 10.0  # far above what a healthy sender sends, and little work
ANY = "*"  # in a key: every name
OPERATOR_CHUNK = "{operator}"


class ChannelSession(StrEnum):
    """Which of a site's two Zenoh sessions carries a channel, so that video never delays control."""

    CONTROL = "control"
    VIDEO = "video"


class Priority(StrEnum):
    """Order of sending within one session."""

    REAL_TIME = "real_time"
    INTERACTIVE = "interactive"
    DATA = "data"


@dataclass(frozen=True, slots=True)
class Keyed:
    """A resource with a Zenoh key in a cell: `key` may contain {cell}, {operator} and {name}.

    A key with {operator} is that operator's alone: where there are certificates, only the certificate of that name
    passes on it, so that the key tells who sends.
    """

    key: str

    @property
    def by_operator(self) -> bool:
        """Return whether every operator has a key of their own."""
        return OPERATOR_CHUNK in self.key

    def key_for(self, cell: str, name: str = ANY, operator: str = ANY) -> str:
        """The Zenoh key in a cell; `name` tells apart what is of one kind, such as cameras."""
        return self.key.format(cell=cell, name=name, operator=operator)

    def operator_in(self, key: str) -> str:
        """The operator whose key this is, empty where the key names none; MessageError for a key that is nobody's."""
        if not self.by_operator:
            return ""
        chunks, place = key.split("/"), self.key.split("/").index(OPERATOR_CHUNK)
        operator = chunks[place] if place < len(chunks) else ""
        if CELL_NAME.fullmatch(operator) is None:
            raise MessageError("nobody", f"{key[:80]} names no operator")
        return operator


@dataclass(frozen=True, slots=True)
class Channel(Keyed, Generic[M]):
    """One channel. Under congestion messages are dropped, publishers never block.

    Access control is built from `sent_by` and `received_by`, where there are certificates. `best_effort` means that the
    next message makes a lost one worthless; a picture of many packets would seldom arrive complete. `depth` is how many
    of the newest messages wait for a receiver, more than 1 where several senders could displace one another's. With
    `in_lanes` a copy of each goes on connections of its own, where the link has them (`lanes.py`).
    """

    message: type[M]
    sent_by: frozenset[Role]
    received_by: frozenset[Role]
    session: ChannelSession
    priority: Priority
    rate_hz: float
    stale_after_ns: int
    max_bytes: int
    depth: int = 1
    best_effort: bool = True
    in_lanes: bool = False

    @property
    def max_hz(self) -> float:
        """The maximum number of messages taken per second, besides a burst of `depth`."""
        return RATE_MARGIN * self.rate_hz


HAND = Channel(
    key="farhand/{cell}/hand/{operator}",
    message=HandArm,
    sent_by=OPERATORS,
    received_by=OPERATORS | REMOTES,
    session=ChannelSession.CONTROL,
    priority=Priority.REAL_TIME,
    rate_hz=30.0,
    stale_after_ns=100 * NS_PER_MS,
    max_bytes=4096,
    depth=16,  # on plain loopback anybody may send on any key: the holder's samples must not be displaced at once
    in_lanes=True,
)
STATE = Channel(
    key="farhand/{cell}/state",
    message=RobotState,
    sent_by=REMOTES,
    received_by=EVERYBODY,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=100.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=16384,
)
CAMERA = Channel(
    key="farhand/{cell}/camera/{name}",
    message=VideoFrame,
    sent_by=REMOTES,
    received_by=EVERYBODY,
    session=ChannelSession.VIDEO,
    priority=Priority.DATA,
    rate_hz=30.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=4_000_000,
    depth=16,  # half a second: of H.264 none may be left out, and after a lost packet many come at once
    best_effort=False,
)
KEY_FRAMES = Channel(
    key="farhand/{cell}/key_frames",
    message=KeyFrameRequest,
    sent_by=EVERYBODY,
    received_by=REMOTES,
    session=ChannelSession.VIDEO,
    priority=Priority.INTERACTIVE,
    rate_hz=40.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=512,
    depth=16,  # several viewers, each of several cameras
)
PREVIEW = Channel(
    key="farhand/{cell}/operator/{operator}/preview/{name}",
    message=VideoFrame,
    sent_by=OPERATORS,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.DATA,
    rate_hz=12.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=1_000_000,
    best_effort=False,
)
SHOWN = Channel(
    key="farhand/{cell}/shown/{operator}",
    message=ViewsShown,
    sent_by=OPERATORS,
    received_by=REMOTES,
    session=ChannelSession.VIDEO,
    priority=Priority.INTERACTIVE,
    rate_hz=10.0,
    stale_after_ns=1000 * NS_PER_MS,
    max_bytes=4096,
    depth=4,  # a console without the lease must not displace the operator's messages
)
INTENT = Channel(
    key="farhand/{cell}/operator/{operator}/intent",
    message=OperatorIntent,
    sent_by=OPERATORS,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=20.0,
    stale_after_ns=200 * NS_PER_MS,
    max_bytes=1024,
    depth=8,  # a second console must not displace what the operating one reports
)
RECORDING = Channel(
    key="farhand/{cell}/operator/{operator}/recording",
    message=RecordingNotice,
    sent_by=OPERATORS,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=5.0,
    stale_after_ns=2 * NS_PER_S,
    max_bytes=4096,
)
RECORDER = Channel(
    key="farhand/{cell}/operator/{operator}/recorder",  # to the local site, which tells the console: RECORDING
    message=RecordingNotice,
    sent_by=OPERATORS,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=5.0,
    stale_after_ns=2 * NS_PER_S,
    max_bytes=4096,
)
RECORD_ORDER = Channel(
    key="farhand/{cell}/operator/{operator}/record_order",  # what the local site has granted: RECORD_OWN
    message=RecordRequest,
    sent_by=OPERATORS,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=10.0,
    stale_after_ns=2 * NS_PER_S,
    max_bytes=4096,
    depth=8,  # each is another order
    best_effort=False,
)
PROBE = Channel(
    key="farhand/{cell}/probe/{operator}",
    message=Probe,
    sent_by=OPERATORS,
    received_by=REMOTES,
    session=ChannelSession.CONTROL,
    priority=Priority.REAL_TIME,  # as the hand samples, of which it measures the way, by one connection
    rate_hz=100.0,
    stale_after_ns=NS_PER_S,
    max_bytes=2048,
    depth=64,  # they are counted: a delay on the way must not look like a loss
)
ECHO = Channel(
    key="farhand/{cell}/echo/{operator}",
    message=ProbeEcho,
    sent_by=REMOTES,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=100.0,
    stale_after_ns=NS_PER_S,
    max_bytes=2048,
    depth=256,
)
LOAD = Channel(
    key="farhand/{cell}/load/{operator}",
    message=Probe,
    sent_by=OPERATORS,
    received_by=REMOTES,
    session=ChannelSession.CONTROL,
    priority=Priority.DATA,
    rate_hz=100.0,
    stale_after_ns=NS_PER_S,
    max_bytes=MOST_PADDING + ROOM_BYTES,
    depth=64,
    best_effort=False,
)
LOAD_ECHO = Channel(
    key="farhand/{cell}/load_echo/{operator}",
    message=ProbeEcho,
    sent_by=REMOTES,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.DATA,
    rate_hz=100.0,
    stale_after_ns=NS_PER_S,
    max_bytes=MOST_PADDING + ROOM_BYTES,
    depth=256,
    best_effort=False,
)


@dataclass(frozen=True, slots=True)
class Procedure(Keyed, Generic[Q, R]):
    """A query that one site answers, on the control session.

    One neighbour may ask `max_hz` times a second of each operator's; more is dropped, where there is access control.
    Who has an operator's certificate asks `of_operators` instead, where there is one.
    """

    request: type[Q]
    reply: type[R]
    asked_by: frozenset[Role]
    answered_by: frozenset[Role]
    max_bytes: int = 2048  # the longest sentence, four bytes a character
    max_hz: float = 1000.0  # a stop may follow another request immediately
    of_operators: "Procedure[Q, R] | None" = None


ENGAGEMENT = Procedure("farhand/{cell}/rpc/engagement/{operator}", EngagementRequest, Reply, OPERATORS, REMOTES)
MAINTENANCE = Procedure("farhand/{cell}/rpc/maintenance", EngagementRequest, Reply, MAINTAINERS, REMOTES)
# Nothing else may displace a stop where it waits, so it has keys, and with them queues, of its own.
STOP = Procedure("farhand/{cell}/rpc/stop/{operator}", StopRequest, Reply, OPERATORS, REMOTES)
MAINTENANCE_STOP = Procedure("farhand/{cell}/rpc/maintenance/stop", StopRequest, Reply, MAINTAINERS, REMOTES)
LEASE = Procedure("farhand/{cell}/rpc/lease/{operator}", LeaseRequest, LeaseReply, OPERATORS, REMOTES, max_bytes=4096)
# What everybody may ask: an operator who floods it delays no other, and neither viewers nor maintenance.
OWN_DESCRIBE = Procedure(
    "farhand/{cell}/rpc/describe/{operator}",
    DescribeQuestion,
    Description,
    OPERATORS,
    REMOTES,
    max_bytes=16384,
    max_hz=200.0,
)
DESCRIBE = replace(OWN_DESCRIBE, key="farhand/{cell}/rpc/describe", asked_by=OTHERS, of_operators=OWN_DESCRIBE)
OWN_CLOCK = Procedure(
    "farhand/{cell}/clock/{operator}", ClockQuestion, ClockAnswer, OPERATORS, REMOTES, max_bytes=256, max_hz=200.0
)
CLOCK = replace(OWN_CLOCK, key="farhand/{cell}/clock", asked_by=OTHERS, of_operators=OWN_CLOCK)
TROUBLE = Procedure("farhand/{cell}/rpc/trouble/{operator}", TroubleReport, TroubleNoted, OPERATORS, REMOTES, max_hz=20)
RECORD = Procedure("farhand/{cell}/rpc/record/{operator}", RecordRequest, Reply, OPERATORS, REMOTES, max_bytes=4096)
RECORD_OWN = Procedure(
    "farhand/{cell}/operator/{operator}/record", RecordRequest, Reply, OPERATORS, OPERATORS, max_bytes=4096
)
JOINTS = Procedure("farhand/{cell}/operator/{operator}/joints", JointsRequest, Reply, OPERATORS, OPERATORS)
OPERATE = Procedure("farhand/{cell}/operator/{operator}/lease", OperatorRequest, Reply, OPERATORS, OPERATORS)
CHANNELS: tuple[Channel[Any], ...] = (
    HAND,
    STATE,
    CAMERA,
    KEY_FRAMES,
    PREVIEW,
    SHOWN,
    INTENT,
    RECORDING,
    RECORDER,
    RECORD_ORDER,
    PROBE,
    ECHO,
    LOAD,
    LOAD_ECHO,
)
PROCEDURES: tuple[Procedure[Any, Any], ...] = (
    ENGAGEMENT,
    MAINTENANCE,
    STOP,
    MAINTENANCE_STOP,
    LEASE,
    DESCRIBE,
    OWN_DESCRIBE,
    CLOCK,
    OWN_CLOCK,
    TROUBLE,
    RECORD,
    RECORD_OWN,
    JOINTS,
    OPERATE,
)


def check_cell_name(cell: str, what: str = "cell") -> str:
    """The name of a cell (or of `what`) if it is valid in a key, else ConfigError."""
    if CELL_NAME.fullmatch(cell) is None:
        raise ConfigError(
            f"{what} {cell!r}: use 1 to 32 small letters, digits, '-' and '_', beginning with a letter or digit"
        )
    return cell

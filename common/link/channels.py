"""The one table of channels: key, message, who sends and who hears, rate, staleness, priority, size, session."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, TypeVar

from common.clock import NS_PER_MS
from common.errors import ConfigError
from common.link.roles import (
    CELL_NAME,
    EVERYBODY,
    MAINTAINERS,
    OPERATORS,
    REMOTES,
    Role,
)
from common.messages.base import Message
from common.messages.hand import HandArm, OperatorIntent
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
    Reply,
)
from common.messages.robot import RobotState
from common.messages.video import VideoFrame, ViewsShown

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
TIMES_ITS_RATE = 10.0  # far above what a sound sender sends, and little work
OPERATORS_HZ = 1000.0  # a stop may follow another request at once
EVERYBODYS_HZ = 200.0


class ChannelSession(StrEnum):
    """Which of a site's two Zenoh sessions carries a channel: video never delays control."""

    CONTROL = "control"
    VIDEO = "video"


class Priority(StrEnum):
    """Order of sending within one session."""

    REAL_TIME = "real_time"
    INTERACTIVE = "interactive"
    DATA = "data"


@dataclass(frozen=True, slots=True)
class Channel(Generic[M]):
    """One channel; `key` may hold {cell} and {name}. Periodic channels drop under congestion, never block.

    `sent_by` and `heard_by` are what access control is made of, where there are certificates.
    `best_effort`: the next message makes a lost one worthless; a picture of many packets would seldom arrive whole.
    `depth` is how many of the newest messages wait for a receiver: 1 where several senders cannot push one another out.
    Who looks now and then takes no more than these at a time; who waits for each, `most_hz`.
    """

    key: str
    message: type[M]
    sent_by: frozenset[Role]
    heard_by: frozenset[Role]
    session: ChannelSession
    priority: Priority
    rate_hz: float
    stale_after_ns: int
    max_bytes: int
    depth: int = 1
    best_effort: bool = True

    @property
    def most_hz(self) -> float:
        """How many messages a second are taken at most, beyond as many at once as may wait; of the newest."""
        return TIMES_ITS_RATE * self.rate_hz

    def key_for(self, cell: str, name: str = "*") -> str:
        """The Zenoh key of this channel in a cell."""
        return self.key.format(cell=cell, name=name)


HAND = Channel(
    key="farhand/{cell}/hand",
    message=HandArm,
    sent_by=OPERATORS,
    heard_by=OPERATORS | REMOTES,
    session=ChannelSession.CONTROL,
    priority=Priority.REAL_TIME,
    rate_hz=30.0,
    stale_after_ns=100 * NS_PER_MS,
    max_bytes=4096,
    depth=16,  # an operator without the lease must not push out the holder's samples, even with 3000 a second
)
STATE = Channel(
    key="farhand/{cell}/state",
    message=RobotState,
    sent_by=REMOTES,
    heard_by=EVERYBODY,
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
    heard_by=EVERYBODY,
    session=ChannelSession.VIDEO,
    priority=Priority.DATA,
    rate_hz=30.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=4_000_000,
    best_effort=False,
)
PREVIEW = Channel(
    key="farhand/{cell}/preview/{name}",
    message=VideoFrame,
    sent_by=OPERATORS,
    heard_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.DATA,
    rate_hz=12.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=1_000_000,
    best_effort=False,
)
SHOWN = Channel(
    key="farhand/{cell}/shown/{name}",
    message=ViewsShown,
    sent_by=OPERATORS,
    heard_by=REMOTES,
    session=ChannelSession.VIDEO,
    priority=Priority.INTERACTIVE,
    rate_hz=10.0,
    stale_after_ns=1000 * NS_PER_MS,
    max_bytes=4096,
    depth=4,  # a console without the lease must not push out what the operator's says
)
INTENT = Channel(
    key="farhand/{cell}/operator/{name}/intent",
    message=OperatorIntent,
    sent_by=OPERATORS,
    heard_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=20.0,
    stale_after_ns=200 * NS_PER_MS,
    max_bytes=1024,
)


@dataclass(frozen=True, slots=True)
class Procedure(Generic[Q, R]):
    """Something asked by a query and answered by one site; `key` may hold {cell} and {name}.

    `most_hz` is how often one neighbour may ask: what comes faster is dropped, where there is access control.
    """

    key: str
    request: type[Q]
    reply: type[R]
    max_bytes: int
    asked_by: frozenset[Role]
    answered_by: frozenset[Role]
    most_hz: float

    def key_for(self, cell: str, name: str = "*") -> str:
        """The Zenoh key of this procedure in a cell."""
        return self.key.format(cell=cell, name=name)


ENGAGEMENT = Procedure(
    "farhand/{cell}/rpc/engagement",
    EngagementRequest,
    Reply,
    max_bytes=1024,
    asked_by=OPERATORS,
    answered_by=REMOTES,
    most_hz=OPERATORS_HZ,
)
MAINTENANCE = Procedure(
    "farhand/{cell}/rpc/maintenance",
    EngagementRequest,
    Reply,
    max_bytes=1024,
    asked_by=MAINTAINERS,
    answered_by=REMOTES,
    most_hz=OPERATORS_HZ,
)
LEASE = Procedure(
    "farhand/{cell}/rpc/lease",
    LeaseRequest,
    LeaseReply,
    max_bytes=2048,
    asked_by=OPERATORS,
    answered_by=REMOTES,
    most_hz=OPERATORS_HZ,
)
DESCRIBE = Procedure(
    "farhand/{cell}/rpc/describe",
    DescribeQuestion,
    Description,
    max_bytes=16384,
    asked_by=EVERYBODY,
    answered_by=REMOTES,
    most_hz=EVERYBODYS_HZ,
)
CLOCK = Procedure(
    "farhand/{cell}/clock",
    ClockQuestion,
    ClockAnswer,
    max_bytes=256,
    asked_by=EVERYBODY,
    answered_by=REMOTES,
    most_hz=EVERYBODYS_HZ,
)
JOINTS = Procedure(
    "farhand/{cell}/operator/{name}/joints",
    JointsRequest,
    Reply,
    max_bytes=1024,
    asked_by=OPERATORS,
    answered_by=OPERATORS,
    most_hz=OPERATORS_HZ,
)
OPERATE = Procedure(
    "farhand/{cell}/operator/{name}/lease",
    OperatorRequest,
    Reply,
    max_bytes=1024,
    asked_by=OPERATORS,
    answered_by=OPERATORS,
    most_hz=OPERATORS_HZ,
)
CHANNELS: tuple[Channel[Any], ...] = (HAND, STATE, CAMERA, PREVIEW, SHOWN, INTENT)
PROCEDURES: tuple[Procedure[Any, Any], ...] = (ENGAGEMENT, MAINTENANCE, LEASE, DESCRIBE, CLOCK, JOINTS, OPERATE)


def check_cell_name(cell: str, what: str = "cell") -> str:
    """The cell's name (or another's, `what`) if it can stand in a key, else ConfigError."""
    if CELL_NAME.fullmatch(cell) is None:
        raise ConfigError(
            f"{what} {cell!r}: use 1 to 32 small letters, digits, '-' and '_', beginning with a letter or digit"
        )
    return cell

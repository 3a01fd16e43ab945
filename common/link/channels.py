"""The one table of channels and procedures: key, messages, roles, session, priority, rate, staleness, size."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Generic, TypeVar

from common.clock import NS_PER_MS
from common.errors import ConfigError
from common.link.roles import CELL_NAME, EVERYBODY, MAINTAINERS, OPERATORS, REMOTES, Role
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
RATE_MARGIN = 10.0  # far above what a healthy sender sends, and little work


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
class Channel(Generic[M]):
    """One channel; `key` may contain {cell} and {name}. Under congestion messages are dropped, publishers never block.

    Access control is built from `sent_by` and `received_by`, where there are certificates. `best_effort` means that the
    next message makes a lost one worthless; a picture of many packets would seldom arrive complete. `depth` is how many
    of the newest messages wait for a receiver, more than 1 where several senders could displace one another's.
    """

    key: str
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

    @property
    def max_hz(self) -> float:
        """The maximum number of messages taken per second, besides a burst of `depth`."""
        return RATE_MARGIN * self.rate_hz

    def key_for(self, cell: str, name: str = "*") -> str:
        """The Zenoh key of this channel in a cell."""
        return self.key.format(cell=cell, name=name)


HAND = Channel(
    key="farhand/{cell}/hand",
    message=HandArm,
    sent_by=OPERATORS,
    received_by=OPERATORS | REMOTES,
    session=ChannelSession.CONTROL,
    priority=Priority.REAL_TIME,
    rate_hz=30.0,
    stale_after_ns=100 * NS_PER_MS,
    max_bytes=4096,
    depth=16,  # an operator without the lease must not displace the holder's samples, even with 3000 a second
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
    best_effort=False,
)
PREVIEW = Channel(
    key="farhand/{cell}/preview/{name}",
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
    key="farhand/{cell}/shown/{name}",
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
    key="farhand/{cell}/operator/{name}/intent",
    message=OperatorIntent,
    sent_by=OPERATORS,
    received_by=OPERATORS,
    session=ChannelSession.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=20.0,
    stale_after_ns=200 * NS_PER_MS,
    max_bytes=1024,
)


@dataclass(frozen=True, slots=True)
class Procedure(Generic[Q, R]):
    """A query that one site answers, on the control session; `key` may contain {cell} and {name}.

    One neighbour may ask `max_hz` times a second; more is dropped, where there is access control.
    """

    key: str
    request: type[Q]
    reply: type[R]
    asked_by: frozenset[Role]
    answered_by: frozenset[Role]
    max_bytes: int = 1024
    max_hz: float = 1000.0  # a stop may follow another request immediately

    def key_for(self, cell: str, name: str = "*") -> str:
        """The Zenoh key of this procedure in a cell."""
        return self.key.format(cell=cell, name=name)


ENGAGEMENT = Procedure("farhand/{cell}/rpc/engagement", EngagementRequest, Reply, OPERATORS, REMOTES)
MAINTENANCE = Procedure("farhand/{cell}/rpc/maintenance", EngagementRequest, Reply, MAINTAINERS, REMOTES)
LEASE = Procedure("farhand/{cell}/rpc/lease", LeaseRequest, LeaseReply, OPERATORS, REMOTES, max_bytes=2048)
DESCRIBE = Procedure(
    "farhand/{cell}/rpc/describe", DescribeQuestion, Description, EVERYBODY, REMOTES, max_bytes=16384, max_hz=200.0
)
CLOCK = Procedure("farhand/{cell}/clock", ClockQuestion, ClockAnswer, EVERYBODY, REMOTES, max_bytes=256, max_hz=200.0)
JOINTS = Procedure("farhand/{cell}/operator/{name}/joints", JointsRequest, Reply, OPERATORS, OPERATORS)
OPERATE = Procedure("farhand/{cell}/operator/{name}/lease", OperatorRequest, Reply, OPERATORS, OPERATORS)
CHANNELS: tuple[Channel[Any], ...] = (HAND, STATE, CAMERA, PREVIEW, SHOWN, INTENT)
PROCEDURES: tuple[Procedure[Any, Any], ...] = (ENGAGEMENT, MAINTENANCE, LEASE, DESCRIBE, CLOCK, JOINTS, OPERATE)


def check_cell_name(cell: str, what: str = "cell") -> str:
    """The name of a cell (or of `what`) if it is valid in a key, else ConfigError."""
    if CELL_NAME.fullmatch(cell) is None:
        raise ConfigError(
            f"{what} {cell!r}: use 1 to 32 small letters, digits, '-' and '_', beginning with a letter or digit"
        )
    return cell

"""The one table of channels: key, message, rate, staleness, priority, what happens under congestion, session."""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from common.clock import NS_PER_MS
from common.errors import ConfigError
from common.messages import HandArm, Message, OperatorIntent, RobotState, VideoFrame, ViewsShown
from common.requests import (
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

M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)
CELL_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")


class Session(StrEnum):
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

    `depth` is how many of the newest messages wait for a receiver: 1 where several senders cannot push one another out.
    """

    key: str
    message: type[M]
    session: Session
    priority: Priority
    rate_hz: float
    stale_after_ns: int
    max_bytes: int
    depth: int = 1

    def key_for(self, cell: str, name: str = "*") -> str:
        """The Zenoh key of this channel in a cell."""
        return self.key.format(cell=cell, name=name)


HAND = Channel(
    key="farhand/{cell}/hand",
    message=HandArm,
    session=Session.CONTROL,
    priority=Priority.REAL_TIME,
    rate_hz=30.0,
    stale_after_ns=100 * NS_PER_MS,
    max_bytes=4096,
    depth=4,  # an operator without the lease must not push out the samples of the one who has it
)
STATE = Channel(
    key="farhand/{cell}/state",
    message=RobotState,
    session=Session.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=100.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=16384,
)
CAMERA = Channel(
    key="farhand/{cell}/camera/{name}",
    message=VideoFrame,
    session=Session.VIDEO,
    priority=Priority.DATA,
    rate_hz=30.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=4_000_000,
)
PREVIEW = Channel(
    key="farhand/{cell}/preview/{name}",
    message=VideoFrame,
    session=Session.CONTROL,
    priority=Priority.DATA,
    rate_hz=12.0,
    stale_after_ns=500 * NS_PER_MS,
    max_bytes=1_000_000,
)
SHOWN = Channel(
    key="farhand/{cell}/shown/{name}",
    message=ViewsShown,
    session=Session.VIDEO,
    priority=Priority.INTERACTIVE,
    rate_hz=10.0,
    stale_after_ns=1000 * NS_PER_MS,
    max_bytes=4096,
)


INTENT = Channel(
    key="farhand/{cell}/operator/{name}/intent",
    message=OperatorIntent,
    session=Session.CONTROL,
    priority=Priority.INTERACTIVE,
    rate_hz=20.0,
    stale_after_ns=200 * NS_PER_MS,
    max_bytes=1024,
)


@dataclass(frozen=True, slots=True)
class Procedure(Generic[Q, R]):
    """Something asked by a query and answered by one site; `key` may hold {cell} and {name}."""

    key: str
    request: type[Q]
    reply: type[R]
    max_bytes: int

    def key_for(self, cell: str, name: str = "*") -> str:
        """The Zenoh key of this procedure in a cell."""
        return self.key.format(cell=cell, name=name)


ENGAGEMENT = Procedure("farhand/{cell}/rpc/engagement", EngagementRequest, Reply, 1024)
LEASE = Procedure("farhand/{cell}/rpc/lease", LeaseRequest, LeaseReply, 2048)
DESCRIBE = Procedure("farhand/{cell}/rpc/describe", DescribeQuestion, Description, 16384)
CLOCK = Procedure("farhand/{cell}/clock", ClockQuestion, ClockAnswer, 256)
JOINTS = Procedure("farhand/{cell}/operator/{name}/joints", JointsRequest, Reply, 1024)
OPERATE = Procedure("farhand/{cell}/operator/{name}/lease", OperatorRequest, Reply, 1024)


def check_cell_name(cell: str, what: str = "cell") -> str:
    """The cell's name (or another's, `what`) if it can stand in a key, else ConfigError."""
    if CELL_NAME.fullmatch(cell) is None:
        raise ConfigError(
            f"{what} {cell!r}: use 1 to 32 small letters, digits, '-' and '_', beginning with a letter or digit"
        )
    return cell

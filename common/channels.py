"""The one table of channels: key, message, rate, staleness, priority, what happens under congestion, session."""

import re
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from common.clock import NS_PER_MS
from common.errors import ConfigError
from common.messages import HandArm, Message, Reply, Request, RobotState, VideoFrame

M = TypeVar("M", bound=Message)
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
    """One channel; `key` may hold {cell} and {name}. Periodic channels drop under congestion, never block."""

    key: str
    message: type[M]
    session: Session
    priority: Priority
    rate_hz: float
    stale_after_ns: int
    max_bytes: int

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


@dataclass(frozen=True, slots=True)
class Procedure:
    """Something that must happen once, asked by a query and answered by the remote site."""

    key: str
    request: type[Request]
    reply: type[Reply]
    max_bytes: int

    def key_for(self, cell: str) -> str:
        """The Zenoh key of this procedure in a cell."""
        return self.key.format(cell=cell)


ENGAGE = Procedure(key="farhand/{cell}/rpc/engage", request=Request, reply=Reply, max_bytes=1024)


def check_cell_name(cell: str) -> str:
    """The cell's name if it can stand in a key, else ConfigError."""
    if CELL_NAME.fullmatch(cell) is None:
        raise ConfigError(
            f"cell {cell!r}: use 1 to 32 small letters, digits, '-' and '_', beginning with a letter or digit"
        )
    return cell

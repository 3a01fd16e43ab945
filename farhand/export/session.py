"""A recorded session as an exporter needs it, whatever kept it; pure."""

from bisect import bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array

Times = NDArray[np.int64]
MOST_PIXELS = 64_000_000  # of a picture, and of all views at an instant; what claims more is not decoded
MOST_VIEWS = 16  # as a site can have


class Signal(NamedTuple):
    """Values (n, k) and when each was measured or sent: (n,) ns by the clock of the host that recorded, rising."""

    t_ns: Times
    values: Array

    def at(self, instants: Times) -> Array:
        """The newest values (m, k) not later than each instant; NaN where there are none yet."""
        index = newest_index(self.t_ns, instants)
        rows = self.values[np.maximum(index, 0)] if len(self.t_ns) else np.zeros((len(index), self.values.shape[1]))
        return np.where((index >= 0)[:, None], rows, np.nan)

    def times_at(self, instants: Times) -> Times:
        """The time of the newest values not later than each instant; 0 where there are none yet."""
        return newest_time(self.t_ns, instants)


class SentActions(NamedTuple):
    """The motions that the robot was really given, after every limit, and the hand sample behind each.

    `motion` is the joints (n, joints) in rad, when each was sent; `opening` (n,) is the gripper's commanded opening in
    m, NaN where it was to stay as it is. The sample was exposed at `hand_ns` (n,) by the recording host's clock and at
    `hand_operator_ns` (n,) by the operator's; both are 0 where no sample was followed.
    """

    motion: Signal
    opening: Array
    hand_ns: Times
    hand_operator_ns: Times


class SessionStates(NamedTuple):
    """From when on (n,) ns the session was in which state."""

    t_ns: Times
    names: tuple[str, ...]

    def at(self, instants: Times) -> list[str]:
        """The state at each instant; empty where none is known yet."""
        return [self.names[k] if k >= 0 else "" for k in newest_index(self.t_ns, instants)]


class SessionSignals(NamedTuple):
    """All of a session but its pictures, by the recording host's clock.

    `joints` (n, joints) are as measured, rad; `tool` (n, 7) is x, y, z in m and the quaternion (x, y, z, w) in the
    base's frame; `gripper` (n, 1) is the measured opening in m, None without a gripper that is measured.
    """

    joints: Signal
    tool: Signal
    gripper: Signal | None
    actions: SentActions
    states: SessionStates


class SessionEpisode(NamedTuple):
    """An episode from `begin_ns` up to `end_ns`; `success` is None where nobody said how it went."""

    number: int
    begin_ns: int
    end_ns: int
    task: str
    success: bool | None
    note: str


class ViewPicture(NamedTuple):
    """A picture of a view as JPEG, and its exposure by the recording host's clock."""

    view: str
    capture_ns: int
    jpeg: bytes


@dataclass(frozen=True, slots=True)
class SessionFacts:
    """The facts of a whole session: `utc_minus_clock_ns` turns its times into ns since 1970, UTC.

    `identity` differs where the session does; `views` are the sizes (width, height) of the pictures by view.
    `episodes` are sorted by their beginnings.
    """

    name: str
    identity: str
    robot: str
    joint_names: tuple[str, ...]
    has_gripper: bool
    views: Mapping[str, tuple[int, int]]
    begin_ns: int
    end_ns: int
    utc_minus_clock_ns: int
    episodes: tuple[SessionEpisode, ...]


class RecordedSession(Protocol):
    """A recorded session as exporters read it."""

    @property
    def facts(self) -> SessionFacts:
        """The facts of the whole session."""
        ...

    def signals(self) -> SessionSignals:
        """All of it but its pictures."""
        ...

    def pictures(self, begin_ns: int, end_ns: int) -> Iterator[ViewPicture]:
        """The pictures of all views exposed in this time, in the order of their exposures."""
        ...


def episode_at(facts: SessionFacts, instant_ns: int) -> SessionEpisode | None:
    """The episode begun last before an instant, if it is under way; None between episodes."""
    begun = bisect_right(facts.episodes, instant_ns, key=lambda one: one.begin_ns)
    newest = facts.episodes[begun - 1] if begun else None
    return newest if newest is not None and instant_ns < newest.end_ns else None


def newest_index(t_ns: Times, instants: Times) -> NDArray[np.intp]:
    """Which of rising times (n,) is the newest not later than each instant (m,); -1 where none is."""
    return np.searchsorted(t_ns, instants, side="right") - 1


def newest_time(t_ns: Times, instants: Times) -> Times:
    """The newest of rising times not later than each instant; 0 where none is."""
    index = newest_index(t_ns, instants)
    found = t_ns[np.maximum(index, 0)] if len(t_ns) else np.zeros(len(index), np.int64)
    return np.where(index >= 0, found, 0)

"""A session at instants of a constant rate: of everything the newest not later than the instant; pure."""

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from common.clock import NS_PER_S
from common.errors import ExportError
from common.geometry import Array
from farhand.export.session import SentActions, SessionFacts, SessionSignals, Times, ViewPicture, newest_index

MOST_INSTANTS = 3_000_000  # of a session: 16 hours at 50 a second, a month at one
INSTANTS_AT_ONCE = 10_000  # whose rows are in memory


class ViewsAt(NamedTuple):
    """The newest picture of each view at an instant."""

    instant_ns: int
    pictures: dict[str, ViewPicture]


class SessionRows(NamedTuple):
    """Signals at instants (n,): joints, tool, opening as measured, and what was sent; NaN and 0 where none is known.

    `sent_opening` (n,) is the opening that the gripper is commanded, m; where it is to stay as it is, the measured one.
    """

    instants: Times
    q: Array
    q_ns: Times
    tool: Array
    opening: Array | None
    sent_q: Array
    sent_ns: Times
    sent_opening: Array
    hand_ns: Times
    hand_operator_ns: Times


def instants(begin_ns: int, end_ns: int, fps: float) -> Times:
    """The instants of this rate from the beginning on, and before the end."""
    count = max(int(np.ceil((end_ns - begin_ns) * fps / NS_PER_S)), 0)
    return begin_ns + np.round(np.arange(count) * (NS_PER_S / fps)).astype(np.int64)


def check_length(facts: SessionFacts, length_ns: int, fps: int) -> None:
    """ExportError if so much of a session comes to more instants than anybody exports; a message can be of any time."""
    seconds = max(length_ns // NS_PER_S, 1)
    if seconds * fps > MOST_INSTANTS:
        slower = MOST_INSTANTS // seconds
        cure = f"give --fps {slower} or less" if slower else "leave it out"
        raise ExportError(
            f"{facts.name}: {seconds} s at {fps} a second are {seconds * fps} rows or frames, and {MOST_INSTANTS} is "
            f"the most; {cure}, or get it again from where it was recorded if it is not that long"
        )


def blocks(at: Times) -> Iterator[Times]:
    """Instants as blocks, so that the rows of one block at a time are in memory."""
    for first in range(0, len(at), INSTANTS_AT_ONCE):
        yield at[first : first + INSTANTS_AT_ONCE]


def known_from(signals: SessionSignals) -> int | None:
    """Find from when on joints, gripper and what was sent are all known, ns; None if one of them never is."""
    needed = [signals.joints, signals.actions.motion, signals.tool]
    needed += [signals.gripper] if signals.gripper is not None else []
    if not all(len(signal.t_ns) for signal in needed):
        return None
    return max(int(signal.t_ns[0]) for signal in needed)


def rows_at(signals: SessionSignals, at: Times) -> SessionRows:
    """Everything but the pictures, at these instants."""
    actions = signals.actions
    opening = None if signals.gripper is None else signals.gripper.at(at)[:, 0]
    return SessionRows(
        at,
        signals.joints.at(at),
        signals.joints.times_at(at),
        signals.tool.at(at),
        opening,
        actions.motion.at(at),
        actions.motion.times_at(at),
        _sent_opening(actions, at, opening),
        _of_action(actions.motion.t_ns, actions.hand_ns, at),
        _of_action(actions.motion.t_ns, actions.hand_operator_ns, at),
    )


def views_at(at: Iterable[int], pictures: Iterator[ViewPicture], views: Sequence[str]) -> Iterator[ViewsAt]:
    """The newest picture of each view, instant by instant, from the first at which every view has one."""
    newest: dict[str, ViewPicture] = {}
    coming = next(pictures, None)
    for instant in at:
        while coming is not None and coming.capture_ns <= instant:
            newest[coming.view] = coming
            coming = next(pictures, None)
        if all(view in newest for view in views):
            yield ViewsAt(int(instant), {view: newest[view] for view in views})


def _sent_opening(actions: SentActions, at: Times, measured: Array | None) -> Array:
    index = newest_index(actions.motion.t_ns, at)
    sent = np.where(index >= 0, actions.opening[np.maximum(index, 0)], np.nan) if len(actions.opening) else np.nan
    kept = np.full(len(at), np.nan) if measured is None else measured
    return np.where(np.isnan(sent), kept, sent)


def _of_action(t_ns: Times, values: Times, at: Times) -> Times:
    index = newest_index(t_ns, at)
    return np.where(index >= 0, values[np.maximum(index, 0)], 0) if len(values) else np.zeros(len(at), np.int64)

"""From the messages of a recording to the signals that exporters need."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from common.messages.robot import GripperCommand, GripperState, SessionState
from common.recording.hand_transcript import LOG
from common.recording.reader import KeptMessage
from common.recording.records import MOST_TIME_NS
from common.recording.summary import LONGEST_NS
from farhand.export.session import SentActions, SessionSignals, SessionStates, Signal, Times
from remote_site.recording.topics import ACTION, GRIPPER, MEASURED, TOOL_MEASURED, WRITTEN, SentAction

SIGNAL_TOPICS = [topic.name for topic in (MEASURED, WRITTEN, TOOL_MEASURED, GRIPPER, ACTION, LOG)]
OF_SESSION = "session"  # whose lines in the log say its state
STATES = frozenset(SessionState)
MM_PER_M = 1000
LARGEST = 1e6  # rad, m; what is measured is far smaller, and a number in single precision


@dataclass
class _Kept:
    """Values and their times, as they come."""

    t_ns: list[int] = field(default_factory=list)
    values: list[list[float]] = field(default_factory=list)

    def add(self, t_ns: int, values: list[float]) -> None:
        """Values of this time; those of one time are kept once. ValueError for what no arm measures."""
        if not all(abs(value) <= LARGEST for value in values):
            raise ValueError(f"a joint, pose or opening of {values}, which no arm has")
        if not self.t_ns or t_ns > self.t_ns[-1]:
            self.t_ns.append(t_ns)
            self.values.append(values)

    def signal(self, width: int) -> Signal:
        """All of them."""
        return Signal(np.array(self.t_ns, np.int64), np.array(self.values, np.float64).reshape(-1, width))


def signals_of(messages: Iterable[KeptMessage], joint_names: Sequence[str]) -> SessionSignals:
    """The signals, from the messages of `SIGNAL_TOPICS` in the order of their times."""
    measured, written, tool, gripper = _Kept(), _Kept(), _Kept(), _Kept()
    actions: list[SentAction] = []
    states: list[tuple[int, str]] = []
    for topic, t_ns, published_ns, data in messages:
        match topic:
            case MEASURED.name:
                measured.add(published_ns, _positions(data, joint_names))
            case WRITTEN.name:
                written.add(published_ns, _positions(data, joint_names))
            case TOOL_MEASURED.name:
                tool.add(published_ns, _pose(data))
            case GRIPPER.name:
                gripper.add(t_ns, [msgspec.json.decode(data, type=GripperState).opening])
            case ACTION.name:
                actions.append(_action(t_ns, data))
            case LOG.name:
                states += _state(t_ns, Log.FromString(data))
    width = len(joint_names)
    opening = gripper.signal(1)
    return SessionSignals(
        measured.signal(width),
        tool.signal(7),
        opening if len(opening.t_ns) else None,
        _sent(written.signal(width), actions, opening),
        SessionStates(np.array([t_ns for t_ns, _ in states], np.int64), tuple(name for _, name in states)),
    )


def _sent(written: Signal, actions: Sequence[SentAction], opening: Signal) -> SentActions:
    """Join what the robot was given with the gripper and the cause of the order behind each motion."""
    orders = {action.command: action for action in actions}
    order_at = {action.written_ns: action.written_command for action in actions}
    behind = [orders.get(order_at.get(t_ns) or 0) for t_ns in written.t_ns.tolist()]
    widest = round(float(opening.values.max()) * MM_PER_M) / MM_PER_M if len(opening.t_ns) else np.nan
    commanded: Mapping[GripperCommand, float] = {
        GripperCommand.OPEN: widest,
        GripperCommand.CLOSED: 0.0,
        GripperCommand.KEEP: np.nan,
    }
    openings = [commanded[order.gripper] if order else np.nan for order in behind]
    causes = [order.cause if order else None for order in behind]
    return SentActions(
        written,
        np.array(openings, np.float64),
        _times(cause.born_ns if cause else 0 for cause in causes),
        _times(cause.capture_ns if cause else 0 for cause in causes),
    )


def _times(t_ns: Iterator[int]) -> Times:
    return np.fromiter(t_ns, np.int64)


def _action(t_ns: int, data: bytes) -> SentAction:
    action = msgspec.json.decode(data, type=SentAction)
    if (cause := action.cause) is not None and (
        abs(cause.born_ns - t_ns) > LONGEST_NS or abs(cause.capture_ns) >= MOST_TIME_NS
    ):
        raise ValueError(f"an action at {t_ns} ns by a hand at {cause.born_ns} ns, by its own clock {cause.capture_ns}")
    return action


def _positions(data: bytes, joint_names: Sequence[str]) -> list[float]:
    by_name: dict[str, float] = {joint.name: joint.position for joint in JointStates.FromString(data).joints}
    return [by_name[name] for name in joint_names]


def _pose(data: bytes) -> list[float]:
    pose: Any = PoseInFrame.FromString(data).pose
    at, turn = pose.position, pose.orientation
    return [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w]


def _state(t_ns: int, line: Any) -> list[tuple[int, str]]:
    """The session's state, from a line of its log: 'engaged (code): sentence'."""
    if line.name != OF_SESSION:
        return []
    word = line.message.partition(" ")[0]
    return [(t_ns, word)] if word in STATES else []

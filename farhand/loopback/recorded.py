"""The figures of a recorded run, computed once more from its recording."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from common.link.channels import HAND, STATE, Channel
from common.messages.codec import decode
from common.messages.hand import HandArm
from common.messages.robot import RobotState
from common.recording.reader import RecordingReader
from farhand.loopback.figures import Figures
from farhand.loopback.recorder import Record

NAMES = (
    "capture_to_command_ms",
    "capture_to_motion_ms",
    "picture_to_command_ms",
    "tracking",
    "follow_mm",
    "follow_lag_ms",
    "control",
    "engagements",
    "holds",
    "followed_share",
    "toggles",
    "stopped",
    "rejected",
)  # the others need the pictures' arrival at the viewer, which no recording of the cell has

M = TypeVar("M", HandArm, RobotState)


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """The run that a recording has: `missing` counts the messages that came here and are not in the file."""

    record: Record
    missing: int
    seconds: float
    size: int


def read_run(path: Path, cell: str, live: Record) -> RecordedRun:
    """The samples and states that came here, as the recording has them; RecordingError for no whole recording."""
    with RecordingReader(path) as reader:
        hands = _same(reader, HAND, HAND.key_for(cell, operator=""), live.hands)
        states = _same(reader, STATE, STATE.key_for(cell), live.states)
        seconds = reader.seconds
    record = Record(hands=hands, states=states)
    missing = len(live.hands) + len(live.states) - len(hands) - len(states)
    return RecordedRun(record, missing, seconds, path.stat().st_size)


def recording_figures(
    path: Path, run: RecordedRun, printed: Figures, recompute: Callable[[Record], Figures]
) -> Figures:
    """Tell how large the recording is, and which of the printed figures it gives otherwise."""
    again = recompute(run.record)
    return {
        "file": str(path),
        "bytes": run.size,
        "bytes_a_minute": round(60 * run.size / run.seconds) if run.seconds else None,
        "missing": run.missing,
        "recomputed": list(NAMES),
        "differing": [name for name in NAMES if again[name] != printed[name]],
    }


def _same(reader: RecordingReader, channel: Channel[M], prefix: str, live: Sequence[M]) -> list[M]:
    """The recorded messages of those that came live, in the order in which these came."""
    topics = [topic for topic in reader.topics if topic.startswith(prefix)]
    found = (decode(kept.data, channel.message, channel.max_bytes) for kept in reader.messages(topics))
    by_number = {(message.session, message.seq): message for message in found}
    numbers = [(message.session, message.seq) for message in live]
    return [by_number[number] for number in numbers if number in by_number]

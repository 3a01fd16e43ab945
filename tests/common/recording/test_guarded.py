"""A recording that can be written no more ends with an alarm; what was written before can be read."""

import struct
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest

from common.recording.config import RecordConfig
from common.recording.guarded import GuardedRecording
from common.recording.hand_transcript import add_log
from common.recording.reader import RecordingReader
from common.recording.session import RecordingPlan, RecordingSession


def write_too_large(_session: RecordingSession) -> None:
    struct.pack("<Q", 1 << 64)


def write_to_a_full_disk(_session: RecordingSession) -> None:
    raise OSError(28, "No space left on device")


@pytest.mark.parametrize(
    ("write", "said"), [(write_too_large, "a number has no room"), (write_to_a_full_disk, "free some space")]
)
def test_what_cannot_be_written_ends_the_recording_with_an_alarm_and_not_its_process(
    tmp_path: Path, write: Callable[[RecordingSession], None], said: str
) -> None:
    plan = RecordingPlan(tmp_path, "cell", "test", RecordConfig())
    recording = GuardedRecording(plan, lambda: datetime(2026, 3, 4, tzinfo=UTC))
    recording.begin(lambda session, now_ns: add_log(session, now_ns, "test", "begins"), 10**9)
    recording.write(lambda session: session.tend(3 * 10**9))
    recording.write(write)
    assert recording.session is None
    assert said in recording.alarm
    assert "start it again" in recording.alarm
    (path,) = tmp_path.iterdir()
    with RecordingReader(path) as reader:
        assert len(list(reader.messages())) == 1

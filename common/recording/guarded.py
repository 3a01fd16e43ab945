"""One recording at a time, which ends with an alarm where nothing more can be written, and never with its process."""

import struct
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime

import structlog

from common.errors import RecordingError
from common.recording.session import Preamble, RecordingPlan, RecordingSession

Write = Callable[[RecordingSession], None]


class GuardedRecording:
    """`session` is the recording under way; `alarm` says why the last one ended that nobody ended, else it is empty.

    `date` gives the date of a recording's beginning.
    """

    def __init__(self, plan: RecordingPlan, date: Callable[[], datetime]) -> None:
        self._plan, self._date = plan, date
        self.session: RecordingSession | None = None
        self.alarm = ""

    def begin(self, preamble: Preamble, now_ns: int) -> None:
        """Begin a recording; `preamble` writes what each of its files has to contain."""
        self.alarm = ""
        self._guarded(lambda: self._open(preamble, now_ns))

    def write(self, write: Write) -> None:
        """Write to the recording under way, if there is one."""
        session = self.session
        if session is not None:
            self._guarded(lambda: write(session))

    def end(self, last: Write) -> None:
        """Write what comes last, and end the recording in order."""
        self.write(last)
        self.write(RecordingSession.end)
        if self.session is not None:
            structlog.get_logger().info("recorded", file=str(self.session.path))
        self.session = None

    def _open(self, preamble: Preamble, now_ns: int) -> None:
        self.session = RecordingSession(self._plan, self._date(), now_ns, preamble)
        structlog.get_logger().info("recording", file=str(self.session.path))

    def _guarded(self, write: Callable[[], None]) -> None:
        try:
            write()
        except (OSError, RecordingError, struct.error) as error:
            why = _why(error)
            session, self.session, self.alarm = self.session, None, f"recording has ended: {why}"
            structlog.get_logger().error("recording has ended", reason=why)
            if session is not None:
                with suppress(RecordingError, OSError):  # the disk may be too full for the index, too
                    session.abandon()


def _why(error: Exception) -> str:
    """Say what ended a recording, and what to do."""
    if isinstance(error, OSError):
        return f"{error.strerror}; free some space, and start it again"
    if isinstance(error, struct.error):
        return f"a number has no room in the file ({error}); start it again"
    return str(error)

"""Log lines of a daemon, written by a thread so that no loop waits for a log; the first refusal of each reason."""

import atexit
import logging
import os
import sys
import threading
import traceback
from collections import Counter
from collections.abc import Mapping
from enum import StrEnum
from functools import cache
from logging.handlers import QueueHandler, QueueListener
from queue import SimpleQueue
from types import TracebackType

import structlog
from structlog.typing import EventDict, Processor, WrappedLogger

from common.errors import MessageError
from common.text import escaped

STANDARD_ERROR = 2
JOURNAL_PRIORITIES = {"critical": 2, "error": 3, "warning": 4, "info": 6, "debug": 7}
LOGFMT = structlog.processors.LogfmtRenderer(key_order=["level", "time", "site", "event"])
MARGIN = "| "  # so that no line of a traceback begins as one of the log does


def catch_strays() -> None:
    """Show what ends this process or a thread without acting on a terminal, and log what libraries warn of."""
    sys.excepthook = _show
    threading.excepthook = lambda thread: _show(thread.exc_type, thread.exc_value, thread.exc_traceback)
    logging.root.handlers = [_LibraryWords(logging.WARNING)]


class _LibraryWords(logging.Handler):
    """Writes what libraries warn of to our log; without a handler it would go to standard error as it is."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line."""
        structlog.get_logger().log(record.levelno, "a library warns", library=record.name, reason=self.format(record))


def _show(kind: type[BaseException], error: BaseException | None, trace: TracebackType | None) -> None:
    """Print a traceback, in one piece, since others write too."""
    lines = "".join(traceback.format_exception(kind, error, trace)).rstrip("\n").split("\n")
    sys.stderr.write("".join(f"{MARGIN}{escaped(line)}\n" for line in lines))


class LogFormat(StrEnum):
    """The format of a daemon's log: `text` is level=... event=... key=value, `json` an object per line."""

    TEXT = "text"
    JSON = "json"


def start_log(site: str, log_format: LogFormat = LogFormat.TEXT) -> None:
    """Log to standard error, naming the site in every line; systemd's journal also gets each line's priority.

    What else this process would write there is led into the log, or made as harmless.
    """
    render: Processor = structlog.processors.JSONRenderer() if log_format is LogFormat.JSON else _as_text
    thread = _log_thread()
    thread.start()
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            lambda _logger, _method, event: {**event, "site": site},  # threads do not inherit context variables
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True, key="time"),
            _for_journal(render) if _is_journal() else render,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(logging.INFO),
        logger_factory=lambda *_: thread.logger,
        cache_logger_on_first_use=False,
    )
    catch_strays()


def log_summary(sentences: Mapping[str, str]) -> None:
    """Log what a run was like, a line for each sentence by its name, before the last line."""
    for name, sentence in sentences.items():
        structlog.get_logger().info("summary", **{name: sentence})


def log_end() -> None:
    """The last line of a daemon that was asked to end, and has."""
    structlog.get_logger().info("ended", reason="it was asked to end")


def finish_log() -> None:
    """Write the lines that still wait, and log no more; a process calls it last, before it prints why it ends."""
    _log_thread().stop()


def _as_text(logger: WrappedLogger, method: str, event: EventDict) -> str:
    """A line of key=value, whatever a driver, a camera or an operator says in it."""
    return escaped(LOGFMT(logger, method, event))


class LogThread:
    """Writes queued lines to standard error; it pauses while the process forks, so that no lock is copied held."""

    def __init__(self) -> None:
        self._queue: SimpleQueue[logging.LogRecord] = SimpleQueue()
        self._listener: QueueListener | None = None
        self._paused = False
        self.logger = logging.Logger("farhand", logging.INFO)
        self.logger.addHandler(QueueHandler(self._queue))
        os.register_at_fork(before=self._pause, after_in_parent=self._resume, after_in_child=self._resume)
        atexit.register(self.stop)

    def start(self) -> None:
        """Start writing to what is standard error now."""
        self.stop()
        self._listener = QueueListener(self._queue, logging.StreamHandler(sys.stderr))
        self._listener.start()

    def stop(self) -> None:
        """Write what is queued, then stop."""
        listener, self._listener = self._listener, None
        if listener is not None:
            listener.stop()

    def _pause(self) -> None:
        self._paused = self._listener is not None
        self.stop()

    def _resume(self) -> None:
        if self._paused:
            self.start()


@cache
def _log_thread() -> LogThread:
    return LogThread()


def _is_journal() -> bool:
    """Return whether systemd reads standard error: it names device and inode of what it connected to the journal."""
    stream = os.fstat(STANDARD_ERROR)
    return os.environ.get("JOURNAL_STREAM") == f"{stream.st_dev}:{stream.st_ino}"


def _for_journal(render: Processor) -> Processor:
    """Lines that begin with their priority, see sd-daemon(3): the journal strips it and filters by it."""

    def prefixed(logger: WrappedLogger, method: str, event: EventDict) -> str:
        priority = JOURNAL_PRIORITIES[event["level"]]
        return f"<{priority}>{render(logger, method, event)!s}"

    return prefixed


class RefusalLog:
    """Logs the first refused message of each reason under `event`, and counts all: a flood must not fill the log."""

    def __init__(self, event: str = "a message is refused") -> None:
        self._event = event
        self.counts: Counter[str] = Counter()

    def note(self, error: MessageError) -> None:
        """Count a refused message."""
        self.counts[error.reason] += 1
        if self.counts[error.reason] == 1:
            structlog.get_logger().warning(self._event, reason=str(error))

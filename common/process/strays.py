"""What else reaches standard error: tracebacks and words of libraries, made as harmless as the lines of the log."""

import logging
import sys
import threading
import traceback
from types import TracebackType

import structlog

from common.text import escaped

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

"""The end of a command: its exit codes, and Ctrl-C and SIGTERM until it listens to them itself.

Of every command alike, 0 is done. FAILED: it was begun and failed, or what was examined is not right. MISUSE: the
options or the configuration were refused before anything began. UNDECIDED: nothing failed, and not all could be judged.
docs/operating.md says the same.
"""

import contextlib
import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import NoReturn

FAILED, MISUSE, UNDECIDED, INTERRUPTED = 1, 2, 3, 130
IMPORTING = "<frozen importlib"  # how the names of the files begin in which Python's own imports are
NOT_STOPPED = "STOP NOT ACKNOWLEDGED: the arm may still move, use the emergency stop."
STOPS = ["stop"], ["maintenance", "stop"]


def catch_signals() -> None:
    """Have SIGINT and SIGTERM raise KeyboardInterrupt, or, within an import, which may swallow that, end the process.

    A command that has something to end in order takes both signals over.
    """
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt)


def sentence(arguments: Sequence[str]) -> str:
    """Return what an interrupted command line says; of a stop, that it is not acknowledged."""
    stops = any(list(arguments[: len(words)]) == words for words in STOPS)
    return f"{NOT_STOPPED} interrupted before an answer came" if stops else "interrupted"


def _interrupt(_number: int, frame: FrameType | None) -> None:
    while frame is not None:
        if frame.f_code.co_filename.startswith(IMPORTING):
            _end()
        frame = frame.f_back
    raise KeyboardInterrupt


def _end() -> NoReturn:
    with contextlib.suppress(OSError, ValueError, RuntimeError):  # no reader, closed, or interrupted while it wrote
        sys.stdout.flush()
    with contextlib.suppress(OSError):
        os.write(2, f"farhand: {sentence(sys.argv[1:])}\n".encode())
    os._exit(INTERRUPTED)

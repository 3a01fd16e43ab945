"""A daemon's life: signals, READY and WATCHDOG to systemd, log lines, an orderly end within two seconds."""

import logging
import os
import signal
import socket
import sys
import threading
from enum import StrEnum
from types import FrameType

import structlog
from structlog.typing import EventDict, Processor, WrappedLogger

STOP_SIGNALS = (signal.SIGTERM, signal.SIGINT)
STANDARD_ERROR = 2
JOURNAL_PRIORITIES = {"critical": 2, "error": 3, "warning": 4, "info": 6, "debug": 7}


class LogFormat(StrEnum):
    """How a daemon writes its log: `text` is level=... event=... key=value, `json` an object per line."""

    TEXT = "text"
    JSON = "json"


class StopFlag:
    """Set by SIGTERM or SIGINT; loops look at it or wait on it."""

    def __init__(self) -> None:
        self._event = threading.Event()

    def install(self) -> None:
        """Catch the stop signals in this process; call from its main thread."""
        for number in STOP_SIGNALS:
            signal.signal(number, self._on_signal)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:  # noqa: ARG002  # the handler's fixed signature
        self._event.set()

    def set(self) -> None:
        """Ask the loops to end, as a signal would."""
        self._event.set()

    def __call__(self) -> bool:
        return self._event.is_set()

    def wait(self, timeout_s: float) -> bool:
        """Wait for the flag; True once it is set."""
        return self._event.wait(timeout_s)


def notify(state: str) -> None:
    """Tell systemd `READY=1`, `WATCHDOG=1` or `STOPPING=1`; nothing happens outside systemd."""
    path = os.environ.get("NOTIFY_SOCKET")
    if not path:
        return
    address = "\0" + path[1:] if path.startswith("@") else path
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as channel:
        channel.connect(address)
        channel.sendall(state.encode())


def start_log(site: str, log_format: LogFormat = LogFormat.TEXT) -> None:
    """Log lines of this process to standard error, named after its site; the journal is told their level besides."""
    render = _renderer(log_format)
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            _named(site),
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True, key="time"),
            _for_journal(render) if _is_journal() else render,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(logging.INFO),
        logger_factory=structlog.PrintLoggerFactory(sys.stderr),
        cache_logger_on_first_use=False,
    )


def _named(site: str) -> Processor:
    """The site in every line, also in those of threads, which have no part in the context of who started them."""

    def named(logger: WrappedLogger, method: str, event: EventDict) -> EventDict:  # noqa: ARG001  # a processor's signature
        return {**event, "site": site}

    return named


def _renderer(log_format: LogFormat) -> Processor:
    if log_format is LogFormat.JSON:
        return structlog.processors.JSONRenderer()
    return structlog.processors.LogfmtRenderer(key_order=["level", "time", "site", "event"])


def _is_journal() -> bool:
    """Whether systemd reads standard error: it names the device and inode of what it has connected to the journal."""
    stream = os.fstat(STANDARD_ERROR)
    return os.environ.get("JOURNAL_STREAM") == f"{stream.st_dev}:{stream.st_ino}"


def _for_journal(render: Processor) -> Processor:
    """Lines that begin with their priority, as sd-daemon(3) has it: the journal takes it off and filters by it."""

    def prefixed(logger: WrappedLogger, method: str, event: EventDict) -> str:
        priority = JOURNAL_PRIORITIES[event["level"]]
        return f"<{priority}>{render(logger, method, event)!s}"

    return prefixed


def ask_for_real_time(priority: int) -> bool:
    """Ask for SCHED_FIFO for the calling thread, and say in the log when it was refused."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        structlog.get_logger().warning(
            "no real-time scheduling", cure="grant CAP_SYS_NICE or LimitRTPRIO; late ticks are likely under load"
        )
        return False
    return True


def be_nice(increment: int) -> None:
    """Give way to the processes that control the robot."""
    os.nice(increment)


def be_idle() -> None:
    """Run only while nobody else wants the processor: for work that may come late or not at all."""
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))

"""Child processes of a site: started by fork, watched by heartbeat, ended in order, never left behind."""

import ctypes
import mmap
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing.process import BaseProcess

import numpy as np
import structlog

from common.clock import NS_PER_S
from common.errors import FarhandError, ProcessError
from common.process.log import finish_log
from common.process.service import StopFlag

PR_SET_PDEATHSIG = 1
PR_SET_NAME = 15
END = signal.SIGUSR1  # from the parent alone, or from the kernel when the parent dies
SENT_TO_ALL = (signal.SIGTERM, signal.SIGABRT)  # by systemd, at a stop and by its watchdog, to every process
END_TIMEOUT_S = 1.5
APART_S = 0.25  # until the next one is told to end
KILL_TIMEOUT_S = 0.5
READY_TIMEOUT_S = 60.0  # OpenGL, a camera or a robot may take half of it on a machine that does much else
READY_POLL_S = 0.01
HEARTBEAT_TIMEOUT_S = 5
REASON_BYTES = 2048
CURE = "see the lines above for why, and start the site again"


class Heartbeat:
    """The time of a child's last beat, in memory shared across a fork; 0 until the child is ready."""

    def __init__(self) -> None:
        self._time_ns = np.frombuffer(mmap.mmap(-1, 8), dtype=np.int64)

    def beat(self) -> None:
        """Report that the loop has completed a round; the first beat reports that the child is ready."""
        self._time_ns[0] = time.monotonic_ns()

    @property
    def last_ns(self) -> int:
        return int(self._time_ns[0])


class EndReason:
    """Why a child ended by itself, as a whole sentence in memory shared across a fork; empty until then."""

    def __init__(self) -> None:
        self._memory = mmap.mmap(-1, REASON_BYTES)

    def leave(self, sentence: str) -> None:
        """Leave a sentence for the parent."""
        left = sentence.encode(errors="replace")[:REASON_BYTES]
        self._memory[: len(left)] = left

    def __str__(self) -> str:
        return self._memory[:].rstrip(b"\0").decode(errors="ignore")


ChildMain = Callable[[StopFlag, Heartbeat], None]


@dataclass
class Child:
    """A child process by its name; `vital` if its site cannot be without it."""

    name: str
    process: BaseProcess
    heartbeat: Heartbeat
    reason: EndReason
    vital: bool = True


@dataclass
class Children:
    """The children of one site; `check` raises when one has died or hangs."""

    site: str
    children: list[Child] = field(default_factory=list)

    def start(self, name: str, main: ChildMain, *, vital: bool = True) -> Child:
        """Fork a child that runs `main`, shown by `ps` as farhand-NAME; it is told to end when its parent dies.

        Fork before opening any session. What is not vital may die: that is logged once, and the others continue.
        """
        heartbeat, reason = Heartbeat(), EndReason()
        context = multiprocessing.get_context("fork")
        arguments = (self.site, name, main, heartbeat, reason, os.getpid())
        process = context.Process(target=_run, args=arguments, name=f"{self.site}-{name}")
        process.start()
        child = Child(name, process, heartbeat, reason, vital)
        self.children.append(child)
        return child

    @property
    def numbers(self) -> list[int]:
        """The process numbers of the children that were started."""
        return [child.process.pid for child in self.children if child.process.pid is not None]

    def wait_ready(self, timeout_s: float, should_stop: StopFlag) -> None:
        """Wait for the first beat of every vital child; ProcessError when one dies or the time is up."""
        deadline = time.monotonic() + timeout_s
        while not should_stop() and self._not_ready():
            self.check_alive()
            if time.monotonic() > deadline:
                late = ", ".join(self._not_ready())
                raise ProcessError(f"{self.site}: {late} not ready after {timeout_s:g} s; {CURE}")
            time.sleep(READY_POLL_S)

    def check(self) -> None:
        """ProcessError why a vital child died, or with the name of one that gave no beat for five seconds."""
        self.check_alive()
        for child in self.children:
            if child.vital and time.monotonic_ns() - child.heartbeat.last_ns > HEARTBEAT_TIMEOUT_S * NS_PER_S:
                raise ProcessError(
                    f"{self.site}: process {child.name} hangs: no heartbeat for {HEARTBEAT_TIMEOUT_S} s; {CURE}"
                )

    def _not_ready(self) -> list[str]:
        return [child.name for child in self.children if child.vital and child.heartbeat.last_ns == 0]

    def check_alive(self) -> None:
        """ProcessError with the sentence that a vital child left when it died, else with its name."""
        dead = [child for child in self.children if not child.process.is_alive()]
        for child in dead:
            if child.vital:
                died = f"{self.site}: process {child.name} died (exit code {child.process.exitcode}); {CURE}"
                raise ProcessError(str(child.reason) or died)
            self.children.remove(child)
            structlog.get_logger().error("died; the site continues without it", process=child.name)

    def end(self) -> None:
        """End the children, the last one started first, so that each still finds what it needs while it ends.

        Who takes long does not keep the others from being told: a driver has to stop its robot.
        """
        deadline = time.monotonic() + END_TIMEOUT_S
        for child in reversed(self.children):
            if child.process.is_alive() and child.process.pid is not None:
                os.kill(child.process.pid, END)
            child.process.join(APART_S)
        for child in reversed(self.children):
            child.process.join(max(0.0, deadline - time.monotonic()))
            if child.process.is_alive():
                _say_killed(child)
                child.process.kill()
                child.process.join(KILL_TIMEOUT_S)


def _say_killed(child: Child) -> None:
    """One that was still starting may be within a call of a library; a later one should have ended."""
    log = structlog.get_logger()
    if child.heartbeat.last_ns == 0:
        log.info("ended while it was starting", process=child.name)
    else:
        log.error("had to be killed", process=child.name)


def leave_stops_to_parent() -> None:
    """Do nothing at a stop signal that came to all processes of the site: the parent alone knows in which order to end.

    A handler, since programs that a robot's library starts would inherit that a signal is ignored.
    """
    for number in SENT_TO_ALL:
        signal.signal(number, lambda *_: None)
        signal.siginterrupt(number, False)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def ends_at_once() -> Iterator[None]:
    """Have this child die of the signal to end, within calls of a library that would not return for it."""
    handler = signal.signal(END, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(END, handler)


def die_with_parent(parent_pid: int, number: signal.Signals = signal.SIGTERM) -> None:
    """Ask the kernel for this signal when the parent dies; exit immediately if it is dead already."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, number)
    if os.getppid() != parent_pid:
        os._exit(1)


def show_as(name: str) -> None:
    """Have `ps` show this process as farhand-NAME."""
    ctypes.CDLL(None).prctl(PR_SET_NAME, f"farhand-{name}".encode())


def _run(site: str, name: str, main: ChildMain, heartbeat: Heartbeat, reason: EndReason, parent_pid: int) -> None:
    should_stop = StopFlag()
    should_stop.install((END,))
    leave_stops_to_parent()
    die_with_parent(parent_pid, END)
    show_as(name)
    structlog.contextvars.bind_contextvars(process=name)
    try:
        main(should_stop, heartbeat)
    except FarhandError as error:
        structlog.get_logger().error(str(error))
        reason.leave(str(error))
        sys.exit(1)
    except (Exception, SystemExit) as error:  # a robot's library may exit
        code = error.code if isinstance(error, SystemExit) and isinstance(error.code, int) else 1
        reason.leave(f"{site}: process {name} died (exit code {code}): {type(error).__name__}: {error}")
        sys.excepthook(type(error), error, error.__traceback__)  # multiprocessing would print it as it is
        sys.exit(code)
    finally:
        finish_log()

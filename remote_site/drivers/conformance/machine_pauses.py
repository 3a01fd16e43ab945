"""Time that a machine keeps from a thread: its wait for a processor, and processors that a host lent to other machines.

Both are the kernel's own counts of time in which a thread could have run and did not. A thread that sleeps or blocks,
with Python's lock or without, waits in no queue, and one that computes runs: so no driver can pass its own time off as
the machine's. What else shows a pause cannot tell these apart: a late wake-up may be due to a driver that holds
Python's lock, and an idle processor to one that waits for its robot. The wait for a processor that this process itself
has used meanwhile does not count, because the driver's own threads are in it.

What the suite depends on waits, too, and may have a lower priority: a simulated robot, and the kernel's workers that
move a serial line's bytes. The robot's process is watched like the thread, and so is one that only sleeps and wakes and
has the ordinary priority of these workers.
"""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from common.clock import NS_PER_MS, NS_PER_S

QUEUED = Path("/proc/thread-self/schedstat")
STOLEN = Path("/proc/stat")
STEAL_COLUMN = 8
STOLEN_EVERY_NS = 10 * NS_PER_MS  # the kernel counts it in such steps, and a machine of many processors answers slowly
MOST_BYTES = 1 << 16


@dataclass(frozen=True, slots=True)
class MachineTimes:
    """Totals in ns: this thread and each process that is watched waited for a processor, this thread and its whole
    process ran, and each processor was stolen.
    """

    queued_ns: int = 0
    watched_ns: tuple[int, ...] = ()
    thread_ns: int = 0
    process_ns: int = 0
    stolen_ns: tuple[int, ...] = ()

    def paused_ns(self, since: "MachineTimes") -> int:
        """Return how long the machine kept this thread from running since then, at least, ns."""
        ran_ns = self.process_ns - since.process_ns
        others_ns = ran_ns - (self.thread_ns - since.thread_ns)
        # the largest, not the sum: what two counts show may be the same time
        return max(0, self.queued_ns - since.queued_ns - others_ns, *_rises(self.stolen_ns, since.stolen_ns))

    def stood_still_ns(self, since: "MachineTimes") -> int:
        """Return how long it kept this thread, or a process that is watched, from running since then, at least, ns."""
        ran_ns = self.process_ns - since.process_ns
        waits = (wait_ns - ran_ns for wait_ns in _rises(self.watched_ns, since.watched_ns))
        return max(0, self.paused_ns(since), *waits)


class PauseMeter(Protocol):
    """Reads what a machine has kept from the thread that reads."""

    def read(self) -> MachineTimes: ...


MeasurePauses = Callable[[], AbstractContextManager[PauseMeter]]


NOTHING = MachineTimes()


class NeverPaused:
    """The meter of a clock that moves by itself: such a machine never pauses."""

    def read(self) -> MachineTimes:
        """Nothing."""
        return NOTHING


class KernelMeter:
    """Linux's counts for the thread that makes it, and for processes by their numbers."""

    def __init__(self, files: ExitStack, watched: Sequence[int]) -> None:
        self._queued, self._stolen = _opened(files, QUEUED), _opened(files, STOLEN)
        self._watched = [_opened(files, Path(f"/proc/{number}/schedstat")) for number in watched]
        self._stolen_ns: tuple[int, ...] = ()
        self._looked_ns = 0

    def read(self) -> MachineTimes:
        """The totals until now."""
        queued_ns = _queued_ns(self._queued)
        watched_ns = tuple(map(_queued_ns, self._watched))
        now_ns = time.monotonic_ns()
        if now_ns - self._looked_ns >= STOLEN_EVERY_NS:
            self._looked_ns, self._stolen_ns = now_ns, stolen_ns(os.pread(self._stolen, MOST_BYTES, 0).decode())
        return MachineTimes(queued_ns, watched_ns, time.thread_time_ns(), time.process_time_ns(), self._stolen_ns)


@contextmanager
def no_pauses() -> Iterator[PauseMeter]:
    """A meter for a clock that moves by itself."""
    yield NeverPaused()


@contextmanager
def machine_pauses(watched: Sequence[int] = ()) -> Iterator[PauseMeter]:
    """A meter of this machine for the thread that enters; one that sees nothing where the kernel does not count.

    `watched` has the numbers of processes on which the driver depends.
    """
    if not counts_pauses():
        yield NeverPaused()
        return
    with ExitStack() as files:
        yield KernelMeter(files, watched)


def counts_pauses() -> bool:
    """Return whether this kernel counts how long a thread waits for a processor."""
    try:
        return QUEUED.read_text(encoding="ascii").split() != ["0", "0", "0"]  # a thread that reads this has run
    except OSError:
        return False


def stolen_ns(stat: str) -> tuple[int, ...]:
    """The time for which each processor was stolen, ns, from the text of `/proc/stat`."""
    rows = (line.split() for line in stat.splitlines() if line.startswith("cpu") and not line.startswith("cpu "))
    tick_ns = NS_PER_S // os.sysconf("SC_CLK_TCK")
    return tuple(int(row[STEAL_COLUMN]) * tick_ns for row in rows)


def _rises(now: tuple[int, ...], then: tuple[int, ...]) -> Iterator[int]:
    return (after - before for after, before in zip(now, then, strict=False))


def _opened(files: ExitStack, path: Path) -> int:
    return files.enter_context(path.open("rb", buffering=0)).fileno()


def _queued_ns(schedstat: int) -> int:
    return int(os.pread(schedstat, MOST_BYTES, 0).split()[1])

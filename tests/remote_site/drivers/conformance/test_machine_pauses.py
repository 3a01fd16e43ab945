"""What counts as the machine's: waiting for a processor that another process has, and nothing that a driver can do."""

import ctypes
import hashlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from common.clock import NS_PER_MS
from remote_site.drivers.conformance.machine_pauses import MachineTimes, counts_pauses, machine_pauses, stolen_ns

BUSY = "import os; os.sched_setaffinity(0, {int(os.sys.argv[1])}); print(flush=True)\nwhile True: pass"
LASTING_S = 0.4
needs_counts = pytest.mark.skipif(not counts_pauses(), reason="this kernel does not count waits for a processor")


@pytest.fixture
def shared_processor() -> Iterator[int]:
    """A processor that another process keeps busy."""
    processor = min(os.sched_getaffinity(0))
    with subprocess.Popen([sys.executable, "-c", BUSY, str(processor)], stdout=subprocess.PIPE) as busy:
        assert busy.stdout is not None
        busy.stdout.readline()
        yield processor
        busy.kill()


def compute() -> None:
    """Run for a while, without Python's lock for most of it."""
    end_s, block = time.monotonic() + LASTING_S, bytes(1 << 20)
    while time.monotonic() < end_s:
        hashlib.sha256(block)


def sleep_with_the_lock() -> None:
    ctypes.PyDLL(None).usleep(round(1e6 * LASTING_S))


def measured(work: Callable[[], None], processor: int | None = None) -> tuple[float, float]:
    """How long a thread that does this waited for a processor, ms, and how much of it was the machine's."""
    times: list[MachineTimes] = []

    def run() -> None:
        if processor is not None:
            os.sched_setaffinity(0, {processor})  # of this thread
        with machine_pauses() as meter:
            times.append(meter.read())
            work()
            times.append(meter.read())

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    before, after = times
    return (after.queued_ns - before.queued_ns) / NS_PER_MS, after.paused_ns(before) / NS_PER_MS


@needs_counts
def test_a_thread_that_shares_its_processor_with_another_process_is_kept_by_the_machine(shared_processor: int) -> None:
    queued_ms, paused_ms = measured(compute, shared_processor)
    assert queued_ms > 1000 * LASTING_S / 10
    assert paused_ms > queued_ms / 2


@needs_counts
@pytest.mark.parametrize("wait", [lambda: time.sleep(LASTING_S), sleep_with_the_lock], ids=["asleep", "lock"])
def test_a_thread_that_waits_by_itself_is_not_kept_by_the_machine(wait: Callable[[], None]) -> None:
    assert measured(wait)[1] < 1000 * LASTING_S / 2


@needs_counts
def test_a_thread_that_waits_for_python_s_lock_is_not_kept_by_the_machine() -> None:
    holder = threading.Thread(target=sleep_with_the_lock)

    def wait_for_it() -> None:
        holder.start()
        holder.join()

    assert measured(wait_for_it)[1] < 1000 * LASTING_S / 2


@needs_counts
def test_a_thread_is_not_kept_by_the_machine_where_its_own_process_has_the_processor() -> None:
    ran_ms: list[float] = []

    def compute_too() -> None:
        compute()
        ran_ms.append(1000 * time.thread_time())

    def beside_another() -> None:
        other = threading.Thread(target=compute_too)  # inherits the processor
        other.start()
        compute()
        other.join()

    queued_ms, paused_ms = measured(beside_another, min(os.sched_getaffinity(0)))
    assert queued_ms > 1000 * LASTING_S / 10
    assert paused_ms < queued_ms - 0.8 * min(ran_ms[0], queued_ms)


def times(queued: int = 0, own: int = 0, process: int = 0, watched: int = 0, stolen: int = 0) -> MachineTimes:
    return MachineTimes(queued, (0, watched), own, process, (0, stolen))


@pytest.mark.parametrize(
    ("since", "paused_ns", "stood_still_ns"),
    [
        (times(queued=60), 60, 60),
        (times(queued=60, own=5, process=5), 60, 60),
        (times(queued=60, own=5, process=45), 20, 20),  # 40 of another thread of the driver
        (times(queued=60, process=80), 0, 0),
        (times(stolen=70), 70, 70),
        (times(queued=60, stolen=70), 70, 70),
        (times(watched=90), 0, 90),  # the robot's process, which no call of the driver waits for
        (times(watched=90, own=80, process=80), 0, 10),  # a driver that computes keeps it waiting, too
        (times(own=60, process=60), 0, 0),
    ],
)
def test_what_the_process_uses_itself_is_not_the_machines(
    since: MachineTimes, paused_ns: int, stood_still_ns: int
) -> None:
    assert since.paused_ns(times()) == paused_ns
    assert since.stood_still_ns(times()) == stood_still_ns


def test_the_stolen_time_of_each_processor_is_read() -> None:
    stat = "cpu  9 9 9 9 9 9 9 7 0 0\ncpu0 1 2 3 4 5 6 7 3 0 0\ncpu1 1 2 3 4 5 6 7 4 0 0\nintr 5 0\n"
    tick_ns = 10**9 // os.sysconf("SC_CLK_TCK")
    assert stolen_ns(stat) == (3 * tick_ns, 4 * tick_ns)

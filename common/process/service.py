"""A daemon's lifecycle: stop signals, READY and WATCHDOG to systemd, scheduling."""

import math
import os
import resource
import select
import signal
import socket
import weakref

import structlog

STOP_SIGNALS = (signal.SIGTERM, signal.SIGINT)


class StopFlag:
    """Set by a signal; loops poll it or wait for it.

    A plain flag, and a counter of the kernel that stays readable once it is set: a lock, as an event has one, would be
    waited for for ever by a handler that has interrupted its holder.
    """

    def __init__(self) -> None:
        self._is_set = False
        self._woken = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        weakref.finalize(self, os.close, self._woken)

    def install(self, signals: tuple[signal.Signals, ...] = STOP_SIGNALS) -> None:
        """Catch the signals, SIGTERM and SIGINT by default, in this process; call from its main thread."""
        for number in signals:
            signal.signal(number, lambda *_: self.set())

    def set(self) -> None:
        """Set the flag, as a signal would; from any thread."""
        self._is_set = True
        os.eventfd_write(self._woken, 1)

    def __call__(self) -> bool:
        return self._is_set

    def wait(self, timeout_s: float) -> bool:
        """Wait for the flag; True once it is set."""
        if not self._is_set and timeout_s > 0:
            waiting = select.poll()
            waiting.register(self._woken, select.POLLIN)
            waiting.poll(math.ceil(timeout_s * 1e3))
        return self._is_set


def notify(state: str) -> None:
    """Send `READY=1`, `WATCHDOG=1` or `STOPPING=1` to systemd; does nothing outside systemd."""
    path = os.environ.get("NOTIFY_SOCKET")
    if not path:
        return
    address = "\0" + path[1:] if path.startswith("@") else path
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC) as channel:
        channel.connect(address)
        channel.sendall(state.encode())


def ask_for_real_time(priority: int) -> bool:
    """Request SCHED_FIFO for the calling thread; log a warning when it is refused."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
    except PermissionError:
        structlog.get_logger().warning(
            "no real-time scheduling", cure="grant CAP_SYS_NICE or LimitRTPRIO; late ticks are likely under load"
        )
        return False
    return True


def be_nice(increment: int) -> None:
    """Yield to the processes that control the robot."""
    os.nice(increment)


def bound_memory(most_bytes: int) -> None:
    """Let this process end rather than take more memory from all others."""
    resource.setrlimit(resource.RLIMIT_DATA, (most_bytes, most_bytes))


def be_idle() -> None:
    """Run only on an idle processor: for work that may be late or never done."""
    os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))

"""An FR3 in MuJoCo that speaks the robot's protocol (franky-sim), in a process of its own, and the time that it shows.

A millisecond of the robot takes as long as the machine needs. Where that is longer than a millisecond, the robot's time
falls behind, and what depends on it can go by its clock.
"""

import mmap
import os
import socket
import time
from collections.abc import Callable, Sequence
from importlib.util import find_spec

import numpy as np
import structlog

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import DriverError, NotInstalledError
from common.process.log import log_summary
from common.process.service import StopFlag, ask_for_real_time

FIFO_PRIORITY = 40  # as a robot's own controller, but below the control loop
PORT = 1337
ADDRESSES = 200
MADE_UP_NS = 3 * NS_PER_MS
SILENT_S = 10.0
# Half of franky-sim's own damping (N m s/rad), with which its last joint trembles at rest from one step to the next.
DAMPING = (225.0, 225.0, 175.0, 175.0, 100.0, 100.0, 100.0)
REAL_TIME = 0.95  # of real time, at least, from the start of the process on
SLOWER = "the simulated robot was slower than real time"
MISSING = "the simulated FR3 needs franky-sim: pip install 'farhand[franka-sim]'"


class SimulatedTime:
    """A `Clock` of the simulated robot's milliseconds, shared across a fork; it begins with this machine's time."""

    def __init__(self) -> None:
        self._time_ns = np.frombuffer(mmap.mmap(-1, 8), dtype=np.int64)
        self._time_ns[0] = time.monotonic_ns()

    def tick(self) -> None:
        """A millisecond of the robot has passed."""
        self._time_ns[0] += NS_PER_MS

    def now_ns(self) -> int:
        """The robot's time, ns."""
        return int(self._time_ns[0])

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Wait for the robot's time; DriverError when it stands still."""
        seen_ns, since = self.now_ns(), time.monotonic()
        while (now_ns := self.now_ns()) < deadline_ns:
            if now_ns != seen_ns:
                seen_ns, since = now_ns, time.monotonic()
            elif time.monotonic() - since > SILENT_S:
                raise DriverError("the simulated robot stands still; has its process ended?")
            time.sleep(0.0003)


def check_installed() -> None:
    """NotInstalledError where franky-sim is missing."""
    if find_spec("franky_sim") is None:
        raise NotInstalledError(MISSING)


def free_address() -> str:
    """An address of this host at which no other robot is simulated."""
    for number in range(ADDRESSES):
        host = f"127.0.{os.getpid() % 250 + 1}.{number + 2}"
        with socket.socket() as probe:
            try:
                probe.bind((host, PORT))
            except OSError:
                continue
            return host
    raise DriverError(f"no address of this host has the robot's port {PORT} free; end other simulated robots")


def run_simulator(
    host: str, q: Sequence[float], clock: SimulatedTime, should_stop: StopFlag, beat: Callable[[], None]
) -> None:
    """Simulate an FR3 that starts at `q` (7,) rad until asked to stop, no faster than real time."""
    from franky_sim import SimulationServer  # noqa: PLC0415  # an extra, and only this process needs it
    from franky_sim.mujoco_simulator import MujocoSimulator  # noqa: PLC0415  # as above

    with MujocoSimulator() as simulator:
        simulator.add_robot(initial_q=tuple(q), kv=DAMPING)
        with SimulationServer(simulator, hostname_candidates=[host]) as server:
            ask_for_real_time(FIFO_PRIORITY)
            begun_ns, robot_ns = time.monotonic_ns(), clock.now_ns()
            due_ns = begun_ns
            while not should_stop():
                server.run_once(realtime=False)
                clock.tick()
                beat()
                due_ns = max(due_ns + NS_PER_MS, time.monotonic_ns() - MADE_UP_NS)
                time.sleep(max(0, due_ns - time.monotonic_ns()) / NS_PER_S)
            pace = (clock.now_ns() - robot_ns) / max(time.monotonic_ns() - begun_ns, 1)
            if pace < REAL_TIME:
                structlog.get_logger().warning(SLOWER, pace=round(pace, 2))
            else:
                log_summary({"simulator": f"the robot's time passed at {pace:.2f} of real time"})

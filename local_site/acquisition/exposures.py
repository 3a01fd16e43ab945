"""When the simulated cameras expose, when their operator began to move, and what is rendered at each exposure."""

import mmap
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from common.cameras.camera import Image
from common.clock import NS_PER_S, Clock
from local_site.simulation.operator import Operator

UNSET = -1
Publish = Callable[[int, Image, int], None]


class Beginning:
    """When the simulated operator began to move, ns; processes forked later see it as soon as it is set."""

    def __init__(self) -> None:
        self._t_ns = np.frombuffer(mmap.mmap(-1, 8), np.int64)
        self._t_ns[0] = UNSET

    def set(self, t_ns: int) -> None:
        """The motion begins at this time; later calls change nothing."""
        if self._t_ns[0] == UNSET:
            self._t_ns[0] = t_ns

    def elapsed_s(self, t_ns: int) -> float:
        """How long the operator has been moving at a time, s: zero before the beginning."""
        begun_ns = int(self._t_ns[0])
        return 0.0 if begun_ns == UNSET else max(0.0, (t_ns - begun_ns) / NS_PER_S)


@dataclass(frozen=True, slots=True)
class Exposure:
    """An instant at which these cameras (0 left, 1 right) expose."""

    t_ns: int
    cameras: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ExposureSchedule:
    """Absolute deadlines: the left camera every period from the start on, the right one of two `offset_ns` later."""

    start_ns: int
    period_ns: int
    offset_ns: int
    cameras: int = 2

    def after(self, t_ns: int) -> Exposure:
        """The first exposure later than this time."""
        first = [self.start_ns + k * self.offset_ns for k in range(self.cameras)]
        times = [start + max(0, (t_ns - start) // self.period_ns + 1) * self.period_ns for start in first]
        return Exposure(min(times), tuple(k for k, time_ns in enumerate(times) if time_ns == min(times)))


class ExposureLoop:
    """Renders the operator when the cameras expose; an exposure more than a period late is skipped."""

    def __init__(
        self, operator: Operator, beginning: Beginning, schedule: ExposureSchedule, clock: Clock, publish: Publish
    ) -> None:
        self._operator = operator
        self._beginning = beginning
        self._schedule = schedule
        self._clock = clock
        self._publish = publish
        self._last_ns = schedule.start_ns - 1

    def expose_next(self) -> None:
        """Wait for the next exposure, stamp it, then render what was to be seen at that instant."""
        oldest_ns = self._clock.now_ns() - self._schedule.period_ns
        exposure = self._schedule.after(max(self._last_ns, oldest_ns))
        self._last_ns = exposure.t_ns
        self._clock.sleep_until_ns(exposure.t_ns)
        capture_ns = self._clock.now_ns()
        t_s = self._beginning.elapsed_s(capture_ns)
        for camera, image in zip(exposure.cameras, self._operator.render(t_s, exposure.cameras), strict=True):
            self._publish(camera, image, capture_ns)

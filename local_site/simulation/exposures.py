"""When the simulated cameras expose, and what is done at each exposure."""

from collections.abc import Callable
from dataclasses import dataclass

from common.cameras.camera import Image
from common.clock import Clock
from local_site.simulation.beginning import Beginning
from local_site.simulation.operators import Operator

LEFT, RIGHT = 0, 1
Publish = Callable[[int, Image, int], None]


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
        left = self._next(self.start_ns, t_ns)
        if self.cameras == 1:
            return Exposure(left, (LEFT,))
        right = self._next(self.start_ns + self.offset_ns, t_ns)
        if left == right:
            return Exposure(left, (LEFT, RIGHT))
        return Exposure(left, (LEFT,)) if left < right else Exposure(right, (RIGHT,))

    def _next(self, first_ns: int, t_ns: int) -> int:
        return first_ns + max(0, (t_ns - first_ns) // self.period_ns + 1) * self.period_ns


class ExposureLoop:
    """Renders the operator at the pace of the cameras; late exposures are caught up within a period, then skipped."""

    def __init__(
        self, operator: Operator, beginning: Beginning, pace: ExposureSchedule, clock: Clock, publish: Publish
    ) -> None:
        self._operator = operator
        self._beginning = beginning
        self._pace = pace
        self._clock = clock
        self._publish = publish
        self._last_ns = pace.start_ns - 1

    def expose_next(self) -> None:
        """Wait for the next exposure, stamp it, then render what was to be seen at that instant."""
        caught_up_ns = self._clock.now_ns() - self._pace.period_ns
        exposure = self._pace.after(max(self._last_ns, caught_up_ns))
        self._last_ns = exposure.t_ns
        self._clock.sleep_until_ns(exposure.t_ns)
        capture_ns = self._clock.now_ns()
        t_s = self._beginning.elapsed_s(capture_ns)
        for camera, image in zip(exposure.cameras, self._operator.render(t_s, exposure.cameras), strict=True):
            self._publish(camera, image, capture_ns)

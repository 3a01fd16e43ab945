"""Measures how many pictures a second a running camera really gives, against what its driver states; pure."""

from common.clock import NS_PER_S

WINDOW_NS = 5 * NS_PER_S
SETTLES_NS = NS_PER_S  # after its opening a camera adjusts itself
LEAST_SHARE = 0.9  # of the stated rate: 29.97 of 30 is as stated, and so is a picture lost now and then
LEAST_WAIT = 0.3  # of the time: who waits less for pictures is too slow for them, and says nothing about the camera


class GivenRate:
    """`slow_fps` is the rate that the camera gave over the last window where that, and the one before, is too few.

    Else it is None.
    """

    def __init__(self, stated_fps: float | None) -> None:
        self._stated_fps = stated_fps
        self.slow_fps: float | None = None
        self._was_slow = False
        self._settled_ns: int | None = None
        self._begin(0)

    def _begin(self, now_ns: int) -> None:
        self._began_ns, self._pictures, self._waited_ns = now_ns, 0, 0

    def note(self, now_ns: int, waited_ns: int) -> None:
        """A picture was read at this time, after a wait for it."""
        if self._settled_ns is None:
            self._settled_ns = now_ns + SETTLES_NS
        if now_ns < self._settled_ns or not self._began_ns:
            self._begin(now_ns)
            return
        self._pictures, self._waited_ns = self._pictures + 1, self._waited_ns + waited_ns
        passed_ns = now_ns - self._began_ns
        if passed_ns >= WINDOW_NS:
            if self._waited_ns >= LEAST_WAIT * passed_ns:
                self._judge(self._pictures * NS_PER_S / passed_ns)
            self._begin(now_ns)

    def _judge(self, fps: float) -> None:
        is_slow = self._stated_fps is not None and fps < LEAST_SHARE * self._stated_fps
        self.slow_fps, self._was_slow = fps if is_slow and self._was_slow else None, is_slow

"""Playback: where a replay stands in its recording while the host's time goes on; pure."""

from common.clock import Clock


class Playback:
    """The recording's time as a clock: it goes on at a speed, stands while paused, and jumps where it is told.

    Times are ns: `begin_ns` and `end_ns` by the recording's clock; at its end it stands. `jumps` counts the jumps.
    """

    def __init__(self, clock: Clock, begin_ns: int, end_ns: int) -> None:
        self._clock = clock
        self.begin_ns, self.end_ns = begin_ns, end_ns
        self._from_ns, self._since_ns = begin_ns, clock.now_ns()
        self._playing, self.speed, self.jumps = True, 1.0, 0

    def now_ns(self) -> int:
        """The recording's time that is shown now."""
        gone_ns = (self._clock.now_ns() - self._since_ns) * self.speed if self._playing else 0.0
        return min(self._from_ns + round(gone_ns), self.end_ns)

    @property
    def is_running(self) -> bool:
        """Return whether its time goes on."""
        return self._playing and self.now_ns() < self.end_ns

    def play(self, *, playing: bool) -> None:
        """Go on, from the beginning again where it stands at the end; or pause."""
        if playing and self.now_ns() >= self.end_ns:
            self.jump(self.begin_ns)
        self._set(self.now_ns())
        self._playing = playing

    def accelerate(self, speed: float) -> None:
        """Go on at this many times the recording's own speed."""
        self._set(self.now_ns())
        self.speed = speed

    def jump(self, to_ns: int) -> None:
        """Show another time, within the recording."""
        self._set(min(max(to_ns, self.begin_ns), self.end_ns))
        self.jumps += 1

    def _set(self, recorded_ns: int) -> None:
        self._from_ns, self._since_ns = recorded_ns, self._clock.now_ns()

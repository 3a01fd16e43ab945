"""How long another process has been silent while this one listened."""

from dataclasses import dataclass


@dataclass
class Silence:
    """Measures how long another process has been silent.

    A listener that was paused itself, as when the whole machine was suspended, received nothing through no fault of
    the other: after more than `pause_ns` between two calls the silence counts from zero again.
    """

    pause_ns: int
    _looked_ns: int | None = None
    _resumed_ns: int = 0

    def of(self, last_ns: int, now_ns: int) -> int:
        """The silence in ns at `now_ns` since `last_ns`; call it in every cycle."""
        if self._looked_ns is not None and now_ns - self._looked_ns > self.pause_ns:
            self._resumed_ns = now_ns
        self._looked_ns = now_ns
        return now_ns - max(last_ns, self._resumed_ns)

"""Silence of another process while this one listened."""

from dataclasses import dataclass

SETTLED_PAUSES = 10  # as long the listener has to listen in time before another pause is none of its own habits


@dataclass
class Silence:
    """Measures how long another process has been silent, in the time in which this one listened.

    A listener that was paused itself, as when the whole machine was suspended, received nothing through no fault of
    the other: more than `pause_ns` between two calls does not count. Nor is it an excuse for ever: a pause that follows
    another before the listener has listened in time for ten of them counts as `pause_ns`. So a listener that is always
    late notices a silence, too: of L ns after (L / pause_ns + 2) turns at most.
    """

    pause_ns: int
    _looked_ns: int | None = None
    _paused_ns: int | None = None
    _heard_ns: int | None = None
    _missed_ns: int = 0

    def of(self, last_ns: int, now_ns: int) -> int:
        """The silence in ns at `now_ns` since `last_ns`; call it in every cycle."""
        if last_ns != self._heard_ns:
            self._heard_ns, self._missed_ns = last_ns, 0
        looked_ns = now_ns if self._looked_ns is None else self._looked_ns
        self._looked_ns = now_ns
        if now_ns - looked_ns > self.pause_ns:
            unheard_ns = now_ns - max(last_ns, looked_ns)  # of this pause
            self._missed_ns += max(unheard_ns - self._counted_ns(looked_ns), 0)
            self._paused_ns = now_ns
        return now_ns - last_ns - self._missed_ns

    def _counted_ns(self, looked_ns: int) -> int:
        """Compute how much of a pause since `looked_ns` counts as silence, ns."""
        settled_ns = SETTLED_PAUSES * self.pause_ns
        return 0 if self._paused_ns is None or looked_ns - self._paused_ns >= settled_ns else self.pause_ns

"""Times every call of a driver, and keeps which were slow by themselves and how long the machine paused."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from common.clock import NS_PER_MS, Clock
from remote_site.drivers.conformance.machine_pauses import PauseMeter
from remote_site.drivers.supervisor.watched_driver import DEADLINE_NS

WINDOW_NS = DEADLINE_NS

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class SlowCall:
    """A call that took too long even without the time for which the machine paused meanwhile, ns."""

    name: str
    took_ns: int
    paused_ns: int

    @property
    def own_ns(self) -> int:
        """The time that the driver itself took of it, ns."""
        return self.took_ns - self.paused_ns

    def __str__(self) -> str:
        limit = f"(limit {DEADLINE_NS / NS_PER_MS:.0f} ms)"
        paused_ms = self.paused_ns / NS_PER_MS
        still = f", without {paused_ms:.0f} ms for which this machine stood still" if paused_ms >= 1 else ""
        return f"{self.name} took {self.own_ns / NS_PER_MS:.0f} ms{still} {limit}"


class CallWatch:
    """To be read: `slow`, the slowest call of each name beyond the deadline, and `longest_pause_ns` of the machine.

    Several pauses within `WINDOW_NS` are as one.
    """

    def __init__(self, clock: Clock, meter: PauseMeter) -> None:
        self._clock, self._meter = clock, meter
        self._before = self._since = meter.read()
        self._since_ns = clock.now_ns()
        self.slow: dict[str, SlowCall] = {}
        self.longest_pause_ns = 0

    def call(self, name: str, call: Callable[[], T]) -> T:
        """Make a call and return its result, or raise what it raises."""
        begun_ns, before = self._clock.now_ns(), self._meter.read()
        try:
            return call()
        finally:
            took_ns = self._clock.now_ns() - begun_ns
            one = SlowCall(name, took_ns, self._meter.read().paused_ns(before))
            if one.own_ns > DEADLINE_NS and (name not in self.slow or one.own_ns > self.slow[name].own_ns):
                self.slow[name] = one

    def note_pause(self) -> None:
        """Keep the longest pause; to be called in every turn."""
        now, now_ns = self._meter.read(), self._clock.now_ns()
        self.longest_pause_ns = max(self.longest_pause_ns, now.stood_still_ns(self._before))
        if now_ns - self._since_ns > WINDOW_NS // 2:
            self._before, self._since, self._since_ns = self._since, now, now_ns

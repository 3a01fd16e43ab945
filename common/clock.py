"""Time: monotonic nanoseconds, one clock for all processes of a host, and a fake one for tests."""

import time
from dataclasses import dataclass
from typing import Protocol

NS_PER_MS = 1_000_000
NS_PER_S = 1_000_000_000


class Clock(Protocol):
    """Anything that tells the time in monotonic nanoseconds and can wait."""

    def now_ns(self) -> int: ...

    def sleep_until_ns(self, deadline_ns: int) -> None: ...


class MonotonicClock:
    """CLOCK_MONOTONIC, which every process of one host shares and wall-clock steps leave alone."""

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        delay_ns = deadline_ns - time.monotonic_ns()
        if delay_ns > 0:
            time.sleep(delay_ns / NS_PER_S)


@dataclass
class FakeClock:
    """A clock that tests move by hand; sleeping moves it to the deadline."""

    time_ns: int = 0

    def now_ns(self) -> int:
        return self.time_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.time_ns = max(self.time_ns, deadline_ns)

    def advance_ms(self, milliseconds: float) -> None:
        self.time_ns += round(milliseconds * NS_PER_MS)


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """The other host's clock minus ours, with the bound of its error, both in nanoseconds."""

    offset_ns: int
    uncertainty_ns: int

    def age_ns(self, stamp_ns: int, now_ns: int) -> int:
        """Upper bound of the age of a stamp made by the other host's clock."""
        return now_ns - (stamp_ns - self.offset_ns) + self.uncertainty_ns


SAME_HOST = ClockOffset(offset_ns=0, uncertainty_ns=0)

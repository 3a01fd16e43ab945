"""The screen's pattern and when it was shown: a pseudo-random sequence, and the page's report on this host's clock."""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import NDArray
from scipy.signal import max_len_seq

from common.clock import NS_PER_MS, RoundTrip
from common.errors import CalibrationError
from common.geometry import Array

REGISTER_BITS = 7
# At most 2.5 flashes a second: from three on they can harm people (WCAG 2.3.1).
HOLD_MS = 200
REFRESH_MS = (2.0, 60.0)
MOST_UNCERTAIN_MS = 10.0


def sequence() -> list[int]:
    """The levels to fade between, 0 black and 1 white: of greatest length, so that it resembles itself nowhere."""
    return [int(bit) for bit in max_len_seq(REGISTER_BITS)[0]]


class PageTrip(msgspec.Struct, frozen=True):
    """One query of this host's clock by the page: asked and answered in the page's ms, the host's time in ns."""

    asked_ms: float
    host_ns: int
    reply_ms: float


class PageReport(msgspec.Struct, frozen=True):
    """The levels that the page drew, in order: (time of the animation frame in the page's ms, level from then on)."""

    trips: tuple[PageTrip, ...]
    drawn: tuple[tuple[float, float], ...]
    refresh_ms: float


@dataclass(frozen=True, slots=True)
class ShownPattern:
    """The level (0 black to 1 white) from each time on, ns on this host's clock; drawn `refresh_ms` apart."""

    drawn_ns: NDArray[np.int64]
    levels: Array
    refresh_ms: float
    clock_uncertainty_ms: float

    def mean_level(self, t_ns: Array, width_ns: float) -> Array:
        """The level averaged over `width_ns` around each time."""
        edges = self.drawn_ns.astype(float)
        integral = np.concatenate([[0.0], np.cumsum(self.levels[:-1] * np.diff(edges))])
        begin, end = (np.interp(t_ns + sign * width_ns / 2, edges, integral) for sign in (-1, 1))
        return np.asarray((end - begin) / width_ns)


def pattern_of(report: PageReport) -> ShownPattern:
    """The report on this host's clock; CalibrationError where the page could not draw or read the time well."""
    best = _best([_as_round_trip(trip) for trip in report.trips])
    uncertainty_ms = best.duration_ns / 2 / NS_PER_MS
    if uncertainty_ms > MOST_UNCERTAIN_MS:
        raise CalibrationError(
            f"the page reads this host's clock to {uncertainty_ms:.0f} ms only; open it on this machine, and close "
            "what keeps it busy"
        )
    if not REFRESH_MS[0] <= report.refresh_ms <= REFRESH_MS[1]:
        raise CalibrationError(
            f"the page draws every {report.refresh_ms:.0f} ms; keep it in front, in a browser that rounds no times"
        )
    # The page's times are of the asking clock, so that the offset leads from them to this host's.
    drawn_ns = np.array([round(t_ms * NS_PER_MS) + best.offset_ns for t_ms, _ in report.drawn], dtype=np.int64)
    levels = np.array([level for _, level in report.drawn], dtype=float)
    return ShownPattern(drawn_ns, levels, report.refresh_ms, uncertainty_ms)


def _as_round_trip(trip: PageTrip) -> RoundTrip:
    asked_ns, reply_ns = round(trip.asked_ms * NS_PER_MS), round(trip.reply_ms * NS_PER_MS)
    return RoundTrip(asked_ns, trip.host_ns, trip.host_ns, reply_ns)


def _best(trips: Sequence[RoundTrip]) -> RoundTrip:
    possible = [trip for trip in trips if trip.possible]
    if not possible:
        raise CalibrationError("the page could not read this host's clock; load it again")
    return min(possible, key=lambda trip: trip.duration_ns)

"""A screen that blinked, and cameras that saw it: exposure, readout line by line, noise, jitter of the time stamps."""

import numpy as np
from numpy.typing import NDArray

from common.clock import NS_PER_MS
from common.geometry import Array
from farhand.calibration.latency.pattern import HOLD_MS, PageReport, PageTrip, ShownPattern, sequence

START_NS = 5_000_000_000_000
REFRESH_MS = 1000 / 60


def shown(start_ms: float = 7_000.0, host_minus_page_ns: int = START_NS) -> PageReport:
    """The report of a page that changes at animation frames; its queries of the clock take 0.2 and 1 ms."""
    bits = sequence()
    frames_ms = (
        np.arange(np.ceil(start_ms / REFRESH_MS), (start_ms + (len(bits) - 1) * HOLD_MS) / REFRESH_MS) * REFRESH_MS
    )
    levels = np.interp((frames_ms - start_ms) / HOLD_MS, np.arange(len(bits)), bits)
    trips = tuple(
        PageTrip(t_ms, round((t_ms + duration_ms / 2) * NS_PER_MS) + host_minus_page_ns, t_ms + duration_ms)
        for t_ms, duration_ms in ((10.0, 1.0), (20.0, 0.2), (30.0, 1.0))
    )
    return PageReport(trips, tuple(zip(frames_ms.tolist(), levels.tolist(), strict=True)), REFRESH_MS)


def seen(
    pattern: ShownPattern,
    delay_ms: float,
    *,
    rate_hz: float = 30.0,
    exposure_ms: float = 8.0,
    readout_ms: float = 0.0,
    contrast: float = 100.0,
    noise: float = 1.0,
    jitter_ms: float = 0.0,
    seed: int = 1,
) -> tuple[NDArray[np.int64], Array]:
    """Time stamps (n,), ns, and brightness (n,) of a camera whose stamps come `delay_ms` after the middle of exposure.

    `jitter_ms` is the standard deviation of the stamps, never early by more than it.
    """
    random = np.random.default_rng(seed)
    begin_ns, end_ns = int(pattern.drawn_ns[0]), int(pattern.drawn_ns[-1])
    exposed_ns = np.arange(begin_ns - 10**9, end_ns + 10**9, 1e9 / rate_hz) + random.uniform(0, 1e9 / rate_hz)
    lines_ms = np.linspace(-readout_ms / 2, readout_ms / 2, 31)
    level = np.mean(
        [pattern.mean_level(exposed_ns + line_ms * NS_PER_MS, exposure_ms * NS_PER_MS) for line_ms in lines_ms], axis=0
    )
    jitter_ns = (random.exponential(jitter_ms, len(exposed_ns)) - jitter_ms) * NS_PER_MS if jitter_ms else 0.0
    stamps_ns = np.sort(exposed_ns + delay_ms * NS_PER_MS + jitter_ns)
    return stamps_ns.astype(np.int64), 60 + contrast * level + random.normal(0, noise, len(level))

"""Delay of a camera's time stamps behind a screen's pattern: cross-correlation with a model of the exposure."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import f as f_distribution

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import CalibrationError
from common.geometry import Array
from farhand.calibration.latency.pattern import ShownPattern

DELAYS_MS = (-100.0, 700.0)
# Exposure and readout together, seen as one box; a rolling shutter exposes the screen's lines one after another.
WIDTHS_MS = (1.0, 4.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0)
COARSE_MS, FINE_MS = 2.0, 0.1
FINE_REACH_MS = 30.0
LEAST_FRAMES = 100
LEAST_CONTRAST = 10.0
LEAST_CORRELATION = 0.8
LEAST_NOISE = 1e-4  # of the variance: a perfect fit would claim to know the delay exactly
CONFIDENCE = 0.95
RATE_STEP = 0.05  # of a whole period more in all the time


@dataclass(frozen=True, slots=True)
class Delay:
    """The time from a change of the screen to the time stamps of the frames that show it.

    `uncertainty_ms` is half the interval of delays that explain the frames as well (95 %), or half the time between
    two refreshes of the screen in which no frame was exposed, if that is longer; `correlation` of the
    brightness with the sequence, `contrast` in grey levels, `rate_hz` of the frames, whose stamps are at most
    `longest_gap_ms` apart.
    """

    delay_ms: float
    uncertainty_ms: float
    correlation: float
    contrast: float
    rate_hz: float
    longest_gap_ms: float


def estimate_delay(stamps_ns: NDArray[np.int64], brightness: Array, pattern: ShownPattern) -> Delay:
    """The delay of frames with these time stamps (n,) and brightness (n,), grey levels.

    CalibrationError where too few frames, too little contrast or too low a correlation allow no answer.
    """
    stamps_ns, brightness = _during(stamps_ns, brightness, pattern)
    low, high = np.percentile(brightness, [5, 95])
    if high - low < LEAST_CONTRAST:
        raise CalibrationError(
            f"it sees the screen change by {high - low:.1f} grey levels only; let the screen fill much of the picture, "
            "make it brighter, and the room darker"
        )
    delays_ms, correlation = _search(stamps_ns, brightness, pattern)
    best = int(np.argmax(correlation))
    if correlation[best] < LEAST_CORRELATION:
        raise CalibrationError(
            f"its pictures follow the screen too little (correlation {correlation[best]:.2f}); keep camera and screen "
            "still, give the camera a fixed exposure (exposure_ms), and let nothing else change in its view"
        )
    begin, end = _interval(delays_ms, correlation, len(stamps_ns))
    rate_hz = _rate_hz(stamps_ns)
    unseen_ms = _unseen_ms(len(stamps_ns), rate_hz, pattern.refresh_ms)
    gaps_ns = np.diff(stamps_ns)
    return Delay(
        (begin + end) / 2,
        max(end - begin, unseen_ms, FINE_MS) / 2,
        float(correlation[best]),
        float(high - low),
        rate_hz,
        float(np.max(gaps_ns)) / NS_PER_MS,
    )


def _during(stamps_ns: NDArray[np.int64], brightness: Array, pattern: ShownPattern) -> tuple[NDArray[np.int64], Array]:
    """The frames that show the sequence, whatever their delay."""
    if len(pattern.drawn_ns) < 2:
        raise CalibrationError("the page has shown no sequence; press Start, and keep it in front until it ends")
    margin_ns = max(WIDTHS_MS) / 2 * NS_PER_MS
    begin_ns = pattern.drawn_ns[0] + DELAYS_MS[1] * NS_PER_MS + margin_ns
    end_ns = pattern.drawn_ns[-1] + DELAYS_MS[0] * NS_PER_MS - margin_ns
    shown = (stamps_ns >= begin_ns) & (stamps_ns <= end_ns)
    if int(shown.sum()) < LEAST_FRAMES:
        raise CalibrationError(
            f"it gave {int(shown.sum())} frames while the screen blinked, {LEAST_FRAMES} are needed; check its rate"
        )
    return stamps_ns[shown], brightness[shown]


def _search(stamps_ns: NDArray[np.int64], brightness: Array, pattern: ShownPattern) -> tuple[Array, Array]:
    """Delays (m,), ms, in fine steps around the best one, and the correlation (m,) of the best width at each."""
    coarse_ms = np.arange(*DELAYS_MS, COARSE_MS)
    correlation = _correlations(stamps_ns, brightness, pattern, coarse_ms)
    middle_ms = coarse_ms[int(np.argmax(correlation))]
    fine_ms = np.arange(middle_ms - FINE_REACH_MS, middle_ms + FINE_REACH_MS, FINE_MS)
    return fine_ms, _correlations(stamps_ns, brightness, pattern, fine_ms)


def _correlations(stamps_ns: NDArray[np.int64], brightness: Array, pattern: ShownPattern, delays_ms: Array) -> Array:
    t_ns = stamps_ns[None, :] - delays_ms[:, None] * NS_PER_MS
    seen = brightness - brightness.mean()
    by_width = []
    for width_ms in WIDTHS_MS:
        level = pattern.mean_level(t_ns, width_ms * NS_PER_MS)
        level -= level.mean(axis=1, keepdims=True)
        scale = np.linalg.norm(level, axis=1) * np.linalg.norm(seen)
        by_width.append(level @ seen / np.maximum(scale, 1e-12))
    return np.asarray(np.max(by_width, axis=0))


def _interval(delays_ms: Array, correlation: Array, frames: int) -> tuple[float, float]:
    """The delays whose residual is not significantly greater than the least one, by an F-test."""
    residual = np.maximum(1.0 - np.maximum(correlation, 0.0) ** 2, LEAST_NOISE)
    freedom = frames - 4  # delay, width, level and contrast
    factor = 1.0 + float(f_distribution.ppf(CONFIDENCE, 1, freedom)) / freedom
    likely = delays_ms[residual <= residual.min() * factor]
    return float(likely.min()), float(likely.max())


def _unseen_ms(frames: int, rate_hz: float, refresh_ms: float) -> float:
    """The longest part of the screen's period in which no frame falls: the screen stands still between refreshes.

    All of it for a camera in step with the screen, nearly nothing for one that drifts against it.
    """
    phase_ms = np.sort(np.arange(frames) * 1000.0 / rate_hz % refresh_ms)
    return float(np.max(np.diff(phase_ms, append=phase_ms[0] + refresh_ms)))


def _rate_hz(stamps_ns: NDArray[np.int64]) -> float:
    """The camera's rate by the periodogram of its time stamps: neither jitter nor lost frames change it."""
    t_s = (stamps_ns - stamps_ns[0]) / NS_PER_S
    about_hz = 1.0 / float(np.median(np.diff(t_s)))
    rates_hz = np.arange(0.9 * about_hz, 1.1 * about_hz, RATE_STEP / t_s[-1])
    # Each rate is one of few, and one of few small steps more: the exponential of the sum is the product of theirs.
    row = math.isqrt(len(rates_hz)) + 1
    firsts, steps = (np.exp(2j * np.pi * np.outer(hz, t_s)) for hz in (rates_hz[::row], rates_hz[:row] - rates_hz[0]))
    power = np.abs(firsts @ steps.T).ravel()[: len(rates_hz)]
    return float(rates_hz[int(np.argmax(power))])

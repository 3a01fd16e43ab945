"""The delay is found from brightness and time stamps, with an uncertainty that holds, or refused with the cure."""

import msgspec
import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.errors import CalibrationError
from farhand.calibration.latency.delay import estimate_delay
from farhand.calibration.latency.pattern import HOLD_MS, pattern_of, sequence
from tests.farhand.calibration.latency.shown_screen import REFRESH_MS, START_NS, seen, shown

PATTERN = pattern_of(shown())


@pytest.mark.slow
@pytest.mark.parametrize(
    "camera",
    [
        {},
        {"exposure_ms": 30.0},
        {"exposure_ms": 2.0, "noise": 0.1},
        {"exposure_ms": 10.0, "readout_ms": 25.0},
        {"jitter_ms": 5.0},
        {"rate_hz": 60.0},
        {"rate_hz": 120.0, "exposure_ms": 2.0},
        {"contrast": 14.0, "noise": 2.0},
        {"rate_hz": 15.0, "exposure_ms": 30.0, "jitter_ms": 3.0},
    ],
    ids=str,
)
def test_the_delay_lies_within_its_uncertainty(camera):
    for seed, delay_ms in enumerate((37.3, 81.0, -6.0, 240.0)):
        found = estimate_delay(*seen(PATTERN, delay_ms, seed=seed, **camera), PATTERN)
        assert abs(found.delay_ms - delay_ms) <= found.uncertainty_ms + 0.2
        assert found.uncertainty_ms <= REFRESH_MS / 2 + 1.0


@pytest.mark.slow
@pytest.mark.parametrize("camera", [{}, {"readout_ms": 25.0}, {"jitter_ms": 4.0}], ids=str)
def test_a_camera_that_drifts_against_the_screen_tells_the_delay_to_a_millisecond(camera):
    found = estimate_delay(*seen(PATTERN, 52.4, rate_hz=29.97, **camera), PATTERN)
    assert found.delay_ms == pytest.approx(52.4, abs=1.0)
    assert found.uncertainty_ms < 2.0
    assert found.rate_hz == pytest.approx(29.97, abs=0.01)


def test_lost_frames_change_nothing():
    stamps_ns, brightness = seen(PATTERN, 52.4, rate_hz=29.97)
    kept = np.random.default_rng(3).random(len(stamps_ns)) > 0.2
    found = estimate_delay(stamps_ns[kept], brightness[kept], PATTERN)
    assert found.delay_ms == pytest.approx(52.4, abs=1.0)
    assert found.rate_hz == pytest.approx(29.97, abs=0.01)
    assert found.longest_gap_ms > 60


def test_a_screen_that_brightens_in_a_curve_is_no_bias():
    stamps_ns, brightness = seen(PATTERN, 52.4, rate_hz=29.97, noise=0.0)
    curved = 60 + 100 * ((brightness - 60) / 100) ** 2
    assert estimate_delay(stamps_ns, curved, PATTERN).delay_ms == pytest.approx(52.4, abs=1.0)


@pytest.mark.parametrize(
    ("series", "cure"),
    [
        (lambda t, b: (t, 60 + (b - 60) / 20), "by 5.* grey levels only; let the screen fill"),
        (lambda t, b: (t, np.random.default_rng(1).uniform(0, 255, len(b))), r"too little .*fixed exposure"),
        (lambda t, b: (t, 220 - b), "too little"),
        (lambda t, b: (t[:130], b[:130]), r"gave \d+ frames while the screen"),
        (lambda t, b: (t + 10**11, b), "gave 0 frames"),
    ],
    ids=["faint", "something else", "inverted", "short", "another time"],
)
def test_what_shows_no_screen_is_refused_with_the_cure(series, cure):
    stamps_ns, brightness = series(*seen(PATTERN, 40.0))
    with pytest.raises(CalibrationError, match=cure):
        estimate_delay(stamps_ns, brightness, PATTERN)


def test_the_report_is_brought_to_this_hosts_clock_by_the_quickest_query():
    assert PATTERN.drawn_ns[0] == pytest.approx(START_NS + 7_000 * NS_PER_MS, abs=REFRESH_MS * NS_PER_MS)
    assert PATTERN.clock_uncertainty_ms == pytest.approx(0.1)


def test_the_pattern_never_flashes_three_times_a_second():
    flashes_per_s = 1000 / (2 * HOLD_MS)
    assert flashes_per_s < 3
    assert set(sequence()) == {0, 1}


@pytest.mark.parametrize(
    ("changes", "cure"),
    [
        ({"trips": ()}, "could not read this host's clock"),
        ({"refresh_ms": 100.0}, "draws every 100 ms"),
    ],
)
def test_a_page_that_could_not_measure_is_refused(changes, cure):
    with pytest.raises(CalibrationError, match=cure):
        pattern_of(msgspec.structs.replace(shown(), **changes))


def test_a_page_that_reads_the_clock_late_is_refused():
    slow = tuple(msgspec.structs.replace(trip, reply_ms=trip.reply_ms + 50) for trip in shown().trips)
    with pytest.raises(CalibrationError, match="to 25 ms only"):
        pattern_of(msgspec.structs.replace(shown(), trips=slow))

"""Faults of the link between two hosts: a partition, jitter, lost packets, and pictures that fill it."""

import time
from typing import Any

from common.clock import NS_PER_S
from tests.faults.acts import impair
from tests.faults.cell_pair import CellPair
from tests.faults.driver_log import ms
from tests.faults.plays import Play, latch
from tests.faults.trial import Trial

BACK_S = 2.0
LEARNT_S = 20.0  # until the age limit allows for what the link loses
CALIBRATION_S = 22.0
UNHURRIED = 0.55  # of the arm's speed: an arm that has to catch up is off the hand for that, and not for what was lost
COARSE_LAGS_MS = range(20, 400, 10)
FULL_QUEUE_MS = 300.0  # a link that is not made for people who wait
SETTLES_WATCHED_S = 4.0


def partition(seconds: float, **healed: Any) -> Play:
    """A partition latches the arm, and the command path is back soon after it heals."""

    def play(trial: Trial) -> None:
        took_ns = 0

        def heal(pair: CellPair) -> None:
            nonlocal took_ns
            healed_ns = time.monotonic_ns()
            pair.impair(**healed)
            pair.wait("the command path", lambda: _receives(pair), 20)
            took_ns = time.monotonic_ns() - healed_ns

        latch(impair(cut=True), heal, says="old", for_s=seconds)(trial)
        trial.note(f"a fresh sample {ms(took_ns):.0f} ms after it healed")
        trial.check(took_ns < BACK_S * NS_PER_S, f"the command path came back after {ms(took_ns):.0f} ms")

    return play


def _receives(pair: CellPair) -> bool:
    """Whether good samples arrive: the newest state counts them, or has enough."""
    ready = pair.state.readiness
    return ready.ready or (ready.code == "collecting" and not ready.reason.startswith("0 "))


def bear(seconds: float, least_fraction: float, share: float = 1.0, **impairment: Any) -> Play:
    """The arm follows over the impaired link, and obeys nothing that is too old."""

    def play(trial: Trial) -> None:
        trial.pair.move(share)
        trial.begin(impair(**impairment))
        time.sleep(seconds)
        trial.follows(least_fraction)
        trial.obeys_nothing_old()

    return play


def lose(loss: float, delay_ms: float, seconds: float) -> Play:
    """Lost packets never latch an arm that is as slow as the link asks for, and hardly raise its tracking error."""

    def play(trial: Trial) -> None:
        trial.pair.impair(delay_ms=delay_ms, loss=loss)
        time.sleep(LEARNT_S)
        bear(seconds, 0.9, UNHURRIED, delay_ms=delay_ms, loss=loss)(trial)
        lossy_ns = trial.fault_ns + 2 * NS_PER_S, time.monotonic_ns()
        trial.pair.impair(delay_ms=delay_ms)
        time.sleep(CALIBRATION_S)
        clean_ns = lossy_ns[1] + 2 * NS_PER_S, time.monotonic_ns()
        clean_mm, lag_ms = _least_error(trial, clean_ns)
        lossy_mm = trial.error_mm(lossy_ns, lag_ms)
        own_mm, own_ms = min((trial.error_mm(lossy_ns, near_ms), near_ms) for near_ms in range(lag_ms - 6, lag_ms + 7))
        trial.note(f"error at {lag_ms} ms {clean_mm:.2f} mm, with loss {lossy_mm:.2f} mm ({own_mm:.2f} at {own_ms} ms)")
        trial.check(lossy_mm <= 1.1 * clean_mm, f"the error rose by {lossy_mm / clean_mm - 1:.0%}")

    return play


def _least_error(trial: Trial, between_ns: tuple[int, int]) -> tuple[float, int]:
    """The least tracking error, rms in mm, and the arm's lag at which it is found, to one ms: 5 ms double the error."""
    coarse_ms = min(COARSE_LAGS_MS, key=lambda lag_ms: trial.error_mm(between_ns, lag_ms))
    near_ms = range(coarse_ms - COARSE_LAGS_MS.step, coarse_ms + COARSE_LAGS_MS.step + 1)
    return min((trial.error_mm(between_ns, lag_ms), lag_ms) for lag_ms in near_ms)


def crowd(mbit_s: float, delay_ms: float, seconds: float) -> Play:
    """Pictures fill the link once a viewer is connected; the hand samples on it arrive hardly later."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.impair(mbit_s=mbit_s, delay_ms=delay_ms, queue_ms=FULL_QUEUE_MS)
        pair.move()
        trial.begin(lambda _: time.sleep(seconds))
        alone_ms = trial.late_ms(99)
        pair.start_page(pair.start_console())
        time.sleep(SETTLES_WATCHED_S)
        trial.begin(lambda _: time.sleep(seconds))
        watched_ms = trial.late_ms(99)
        trial.note(f"exposure to command p99 {alone_ms:.1f} ms alone, {watched_ms:.1f} ms beside the video")
        trial.check(watched_ms <= 1.3 * alone_ms, f"it rose by {watched_ms / alone_ms - 1:.0%}")
        trial.follows(0.95)

    return play

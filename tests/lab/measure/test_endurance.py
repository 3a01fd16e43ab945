"""What the bench of an hour says of processes that grow, and of those that do not."""

import os

import pytest

from lab.measure.endurance import Usage, growth, usage_of

HOUR_S = 3600


def usages(mb_per_hour: float, descriptors_per_hour: float) -> list[Usage]:
    """A process over an hour, that for a moment holds more now and then."""
    times = range(0, HOUR_S, 5)
    burst = [20 if k % 37 == 0 else 0 for k in range(len(times))]
    return [
        Usage(t, 100 + mb_per_hour * t / HOUR_S + more, 30 + int(descriptors_per_hour * t / HOUR_S) + more, 8)
        for t, more in zip(times, burst, strict=True)
    ]


def test_a_process_that_grows_is_seen_to_by_how_much() -> None:
    figures = growth(usages(mb_per_hour=12.0, descriptors_per_hour=10))
    assert figures["mb_per_hour"] == pytest.approx(12.0, abs=0.1)
    assert figures["fds_last"] - figures["fds_first"] == pytest.approx(8, abs=1)


def test_what_comes_and_goes_is_no_growth() -> None:
    figures = growth(usages(mb_per_hour=0.0, descriptors_per_hour=0))
    assert figures["mb_per_hour"] == 0.0
    assert (figures["fds_first"], figures["threads_first"]) == (figures["fds_last"], figures["threads_last"])


def test_too_few_looks_say_so() -> None:
    with pytest.raises(ValueError, match="at least 5"):
        growth(usages(0.0, 0)[:4])


def test_this_process_is_looked_at_and_one_that_has_ended_is_none() -> None:
    before = usage_of(os.getpid(), 0.0)
    assert before is not None
    with open(os.devnull, "rb"):
        during = usage_of(os.getpid(), 0.0)
    assert during is not None
    assert during.descriptors == before.descriptors + 1
    assert usage_of(2**22 + 1, 0.0) is None


def test_what_fills_once_is_no_growth() -> None:
    filled = [Usage(t, 100 + min(t / 60, 20), 30, 8) for t in range(0, HOUR_S, 5)]
    figures = growth(filled)
    assert figures["mb_last"] - figures["mb_first"] > 10
    assert figures["mb_per_hour"] == 0.0

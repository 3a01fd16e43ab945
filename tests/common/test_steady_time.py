"""Whatever two hosts' clocks do, the stated greatest age of a stamp is never less than its true one."""

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import pytest

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate, ClockOffset, OffsetEstimator, RoundTrip
from common.host_clock import host_time
from common.messages.hand import ClockSync
from common.steady_time import HostTime, OwnReadings, SteadyEstimator
from remote_site.session.samples import as_of_now
from tests.present import present
from tests.remote_site.remote_loop import hand

SLEW = 0.0833
DAY_NS = 86_400 * NS_PER_S
MEASURED_NS, SAMPLE_NS, STEP_NS = 200 * NS_PER_MS, 33 * NS_PER_MS, NS_PER_MS
LEAST_NS = 20_000  # of the crystals, and of what is read one after the other

Slew = Callable[[float], float]  # by the true time in s


@dataclass
class SimulatedHost:
    """A host whose monotonic clock is slewed as `slew` says, and stands still from `suspend_s` to its end."""

    boot_ns: int
    slew: Slew
    suspend_s: tuple[float, float] = (0.0, 0.0)
    _true_ns: int = 0
    _now_ns: float = field(default=0.0, init=False)

    def at(self, true_ns: int) -> HostTime:
        """Its clocks at a true time, which may not go back."""
        while self._true_ns < true_ns:
            step_ns = min(STEP_NS, true_ns - self._true_ns)
            true_s = self._true_ns / NS_PER_S
            if not self.suspend_s[0] <= true_s < self.suspend_s[1]:
                self._now_ns += step_ns * (1.0 + self.slew(true_s))
            self._true_ns += step_ns
        now_ns = self.boot_ns + round(self._now_ns)
        return HostTime(now_ns, self._true_ns - now_ns)


def steady(_true_s: float) -> float:
    return 0.0


def from_2_s(true_s: float) -> float:
    return SLEW if true_s > 2.0 else 0.0


def back_and_forth(true_s: float) -> float:
    return SLEW if true_s % 3.0 < 1.3 else -SLEW


def reversed_of(slew: Slew) -> Slew:
    return lambda true_s: -slew(true_s)


SLEWS = (steady, from_2_s, back_and_forth)
PAIRS = [(one, other) for a in SLEWS for b in SLEWS for one in (a, reversed_of(a)) for other in (b, reversed_of(b))]


@dataclass
class Sites:
    """Both hosts, questions that take up to 60 ms each way, and none while the local site is `paused_s`."""

    local: SimulatedHost
    remote: SimulatedHost
    paused_s: tuple[float, float] = (0.0, 0.0)

    def events(self, seed: int, until_s: float) -> Iterator[tuple[str, tuple[int, ...]]]:
        """What happens at which true times: questions (asked, answered, replied), samples and pictures (captured,
        sent, arrived), in the order of their last."""
        chance, found = random.Random(seed), []  # noqa: S311  # delays, the same each time
        for asked_ns in range(0, round(until_s * NS_PER_S), MEASURED_NS):
            there_ns, back_ns = (round(chance.uniform(1, 60) * NS_PER_MS) for _ in range(2))
            if not self.paused_s[0] <= asked_ns / NS_PER_S < self.paused_s[1]:
                found.append(("trip", (asked_ns, asked_ns + there_ns, asked_ns + there_ns + back_ns)))
        for captured_ns in range(NS_PER_S // 3, round(until_s * NS_PER_S), SAMPLE_NS):
            sent_ns = captured_ns + round(chance.uniform(10, 100) * NS_PER_MS)
            for kind in ("sample", "picture"):
                found.append((kind, (captured_ns, sent_ns, sent_ns + round(chance.uniform(1, 80) * NS_PER_MS))))
        yield from found


class Instants:
    """Reads both hosts at all the times that events need, in order, once."""

    def __init__(self, sites: Sites, events: list[tuple[str, tuple[int, ...]]]) -> None:
        self.events = sorted(events, key=lambda event: event[1][-1])
        times = sorted({t_ns for _, all_ns in events for t_ns in all_ns})
        self.local = {t_ns: sites.local.at(t_ns) for t_ns in times}
        self.remote = {t_ns: sites.remote.at(t_ns) for t_ns in times}


def least_margins_ms(sites: Sites, seed: int, until_s: float = 14.0) -> dict[str, float]:
    """By how much the stated greatest age of a hand sample, and of a picture, is above its true one, at least.

    As samples are stamped at sending, the actions of a true time are done in its order.
    """
    at = Instants(sites, list(sites.events(seed, until_s)))
    estimator, margins = SteadyEstimator(), dict[str, list[int]](sample=[], picture=[])
    acts = [(all_ns[-1], kind, all_ns) for kind, all_ns in at.events if kind != "sample"]
    acts += [(all_ns[1], kind, all_ns) for kind, all_ns in at.events if kind == "sample"]
    aheads = aheads_of_pictures(at)
    for _, kind, (first_ns, middle_ns, last_ns) in sorted(acts):
        true_ns = last_ns - first_ns
        if kind == "trip":
            answered = at.remote[middle_ns]
            estimator.add(at.local[first_ns], answered.now_ns, answered, at.local[last_ns])
        elif kind == "sample":
            captured_ns = at.local[first_ns].now_ns
            known = estimator.estimate(at.local[middle_ns], captured_ns)
            if known is not None:
                margins[kind].append(stated_age_ns(known, captured_ns, at.remote[last_ns]) - true_ns)
        else:
            known = estimator.estimate(at.local[last_ns])
            if known is not None:
                stamp_ns = at.remote[first_ns].now_ns
                offset = known.of_stamp(aheads[first_ns, middle_ns])
                margins[kind].append(offset.age_ns(stamp_ns, at.local[last_ns].now_ns) - true_ns)
    return {kind: min(all_ns) / NS_PER_MS for kind, all_ns in margins.items()}


def aheads_of_pictures(at: Instants) -> dict[tuple[int, ...], int]:
    """What the remote site tells with each picture, by its capture and its sending."""
    readings, told = OwnReadings(), dict[tuple[int, ...], int]()
    readings.note(at.remote[min(at.remote)])
    sendings = [(all_ns[1], all_ns[0]) for kind, all_ns in at.events if kind == "picture"]
    for sent_ns, captured_ns in sorted(sendings):
        readings.note(at.remote[sent_ns])
        told[captured_ns, sent_ns] = readings.least_ahead_ns(at.remote[captured_ns].now_ns)
    return told


def stated_age_ns(known: ClockEstimate, captured_ns: int, arrived: HostTime) -> int:
    """The age of a sample as the remote site reckons it when it comes, by the clocks' offset in it."""
    offset = known.offset
    clock = ClockSync(
        remote_minus_local_ns=offset.offset_ns,
        uncertainty_ns=offset.uncertainty_ns,
        measured_ns=known.measured_ns,
        remote_ahead_ns=known.their_ahead_ns,
    )
    sample = as_of_now(hand(1, captured_ns, clock=clock), arrived.ahead_ns)
    assert sample.clock is not None
    return arrived.now_ns - captured_ns - sample.clock.remote_minus_local_ns + sample.clock.uncertainty_ns


@pytest.mark.parametrize(("local", "remote"), PAIRS)
def test_slews_of_either_clock_never_make_a_sample_or_a_picture_younger_than_it_is(local, remote):
    sites = Sites(SimulatedHost(DAY_NS, local), SimulatedHost(3 * DAY_NS, remote))
    margins = least_margins_ms(sites, seed=1, until_s=8.0)
    assert min(margins.values()) > -LEAST_NS / NS_PER_MS


@pytest.mark.parametrize("slew", [SLEW, -SLEW])
def test_nor_does_a_pause_without_questions_while_a_clock_is_slewed(slew):
    sites = Sites(SimulatedHost(DAY_NS, lambda _: -slew), SimulatedHost(3 * DAY_NS, lambda _: slew), (3.0, 6.8))
    assert min(least_margins_ms(sites, seed=2, until_s=8.0).values()) > -LEAST_NS / NS_PER_MS


@pytest.mark.parametrize("who", ["local", "remote"])
def test_what_was_captured_before_a_suspend_is_told_to_be_as_old_as_it_is(who):
    suspend_s = 4.0, 604.0
    local = SimulatedHost(DAY_NS, steady, suspend_s if who == "local" else (0.0, 0.0))
    remote = SimulatedHost(3 * DAY_NS, steady, suspend_s if who == "remote" else (0.0, 0.0))
    before_ns, after_ns = 3_950 * NS_PER_MS, 604_007 * NS_PER_MS
    estimator, readings = SteadyEstimator(), OwnReadings()
    for asked_ns in range(0, before_ns, MEASURED_NS):
        answered = remote.at(asked_ns + NS_PER_MS)
        readings.note(answered)
        asked = local.at(asked_ns)
        estimator.add(asked, answered.now_ns, answered, local.at(asked_ns + 2 * NS_PER_MS))
    captured, exposed = local.at(before_ns), remote.at(before_ns)
    known = estimator.estimate(captured, captured.now_ns)
    assert known is not None
    here, there = local.at(after_ns), remote.at(after_ns)
    true_ns = after_ns - before_ns
    if who == "remote":
        assert stated_age_ns(known, captured.now_ns, there) >= true_ns
    assert estimator.estimate(here) is None
    answered = remote.at(after_ns + NS_PER_MS)
    estimator.add(here, answered.now_ns, answered, local.at(after_ns + 2 * NS_PER_MS))
    back_ns = after_ns + 3 * NS_PER_MS
    here, there = local.at(back_ns), remote.at(back_ns)
    picture = estimator.estimate(here)
    assert picture is not None
    readings.note(there)
    ahead_ns = readings.least_ahead_ns(exposed.now_ns)
    assert picture.of_stamp(ahead_ns).age_ns(exposed.now_ns, here.now_ns) >= true_ns
    late = estimator.estimate(here, captured.now_ns)
    assert late is not None
    assert stated_age_ns(late, captured.now_ns, there) >= true_ns


def test_without_slews_an_offset_is_as_sure_as_by_the_monotonic_clocks():
    sites = Sites(SimulatedHost(DAY_NS, steady), SimulatedHost(3 * DAY_NS, steady))
    estimator, plain, compared = SteadyEstimator(), OffsetEstimator(), 0
    at = Instants(sites, list(sites.events(3, 8.0)))
    for kind, (first_ns, middle_ns, last_ns) in at.events:
        now = at.local[last_ns]
        if kind == "trip":
            answered = at.remote[middle_ns]
            estimator.add(at.local[first_ns], answered.now_ns, answered, now)
            plain.add(RoundTrip(at.local[first_ns].now_ns, answered.now_ns, answered.now_ns, now.now_ns))
        elif (known := estimator.estimate(now, at.local[first_ns].now_ns)) is not None:
            assert known.offset == present(plain.estimate(now.now_ns)).offset
            compared += 1
    assert compared > 200


def test_the_clocks_of_this_host_are_read_together():
    readings = [host_time() for _ in range(50)]
    assert max(r.ahead_ns for r in readings) - min(r.ahead_ns for r in readings) < NS_PER_MS
    assert all(before.now_ns <= after.now_ns for before, after in pairwise(readings))


def test_a_stamp_of_which_one_side_tells_no_steady_time_has_the_offset_as_it_is():
    offset = ClockOffset(70, 3)
    assert ClockEstimate(offset, 1, their_ahead_ns=5).of_stamp(None) == offset
    assert ClockEstimate(offset, 1).of_stamp(9) == offset
    assert ClockEstimate(offset, 1, their_ahead_ns=5).of_stamp(9) == ClockOffset(66, 3)

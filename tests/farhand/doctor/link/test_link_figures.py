"""From made-up echoes to the link's figures: round trip, jitter, loss of each way, stalls behind lost packets."""

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from farhand.doctor.link.figures import Echoed, link_figures
from farhand.doctor.link.probing import FIRST_BYTES, LoadWindow

APART_NS = 7 * NS_PER_S  # the remote clock is ahead
PERIOD_MS = 33.0
LOAD = 16_000


def echoes(there_ms: list[float], back_ms: list[float], lost_there: set[int], lost_back: set[int]) -> list[Echoed]:
    """What comes back of as many probes as there are times in transit."""
    come, received = [], 0
    for seq, (there, back) in enumerate(zip(there_ms, back_ms, strict=True)):
        if seq in lost_there:
            continue
        received += 1
        if seq in lost_back:
            continue
        sent = round(seq * PERIOD_MS * NS_PER_MS)
        there_ns, back_ns, held_ns = (round(ms * NS_PER_MS) for ms in (there, back, 3.0))
        arrived = sent + there_ns + held_ns + back_ns
        at_cell = sent + there_ns + APART_NS
        come.append(Echoed(seq, sent, at_cell, at_cell + held_ns, arrived, received))
    return come


def test_the_round_trip_leaves_out_the_time_at_the_cell() -> None:
    rng = np.random.default_rng(1)
    there, back = (40.0 + rng.uniform(0, 8, 300)).tolist(), (20.0 + rng.uniform(0, 2, 300)).tolist()
    figures = link_figures("quic/cell:7447", 300, echoes(there, back, set(), set()))
    assert figures.least_ms == pytest.approx(60.0, abs=1.0)
    assert figures.median_ms == pytest.approx(65.0, abs=0.5)
    assert figures.p99_ms == pytest.approx(69.5, abs=0.5)
    assert figures.there.jitter_ms == pytest.approx(8 / 3, rel=0.1)
    assert figures.back.jitter_ms == pytest.approx(2 / 3, rel=0.1)
    assert figures.there.excess_p99_ms == pytest.approx(7.9, abs=0.2)
    assert (figures.there.loss, figures.back.loss, figures.loss) == (0.0, 0.0, 0.0)


def test_loss_is_told_apart_by_its_way() -> None:
    there, back = [40.0] * 200, [40.0] * 200
    found = echoes(there, back, lost_there=set(range(0, 190, 10)), lost_back={5, 15, 25})
    figures = link_figures("quic/cell:7447", 200, found)
    assert figures.there.loss == pytest.approx(19 / 200)
    assert figures.back.loss == pytest.approx(3 / 181)
    assert figures.loss == figures.there.loss


def test_echoes_that_overtake_one_another_or_come_twice_are_no_loss() -> None:
    found = echoes([40.0] * 50, [40.0] * 50, set(), set())
    found[10], found[11] = found[11], found[10]
    figures = link_figures("quic/cell:7447", 50, [*found, found[-1]])
    assert (figures.there.loss, figures.back.loss) == (0.0, 0.0)


def test_what_tcp_hides_shows_as_stalls_of_more_than_a_round_trip() -> None:
    """Every tenth packet is lost: it comes two round trips later, and what follows waits for it."""
    there = [40.0] * 300
    for lost in range(5, 300, 10):
        for behind in range(4):
            there[lost + behind] += 200.0 - behind * PERIOD_MS
    figures = link_figures("tls/cell:7447", 300, echoes(there, [40.0] * 300, set(), set()))
    assert figures.there.stalls == pytest.approx(30 / (300 - 3 * 30))  # three behind each could begin none
    assert figures.back.stalls == 0.0
    jittery = (40.0 + np.random.default_rng(2).uniform(0, 20, 300)).tolist()
    assert link_figures("tls/cell:7447", 300, echoes(jittery, jittery, set(), set())).loss == 0.0


class Pipe:
    """A link of this rate and delay, in front of which load waits; how long it waited at most, ms."""

    def __init__(self, mbit_s: float, delay_ms: float) -> None:
        self._byte_ns, self._delay_ns = 8e3 / mbit_s, round(delay_ms * NS_PER_MS)
        self._free_ns, self.most_waiting_ms = 0.0, 0.0
        self.arriving: list[tuple[int, int]] = []

    def take(self, number: int, now_ns: int) -> None:
        self._free_ns = max(self._free_ns, now_ns) + LOAD * self._byte_ns
        self.most_waiting_ms = max(self.most_waiting_ms, (self._free_ns - now_ns) / NS_PER_MS)
        self.arriving.append((round(self._free_ns) + 2 * self._delay_ns, number))


@pytest.mark.parametrize(("mbit_s", "delay_ms"), [(2.0, 20.0), (5.0, 120.0), (20.0, 40.0), (50.0, 40.0)])
def test_load_fills_the_link_and_hardly_its_queue(mbit_s: float, delay_ms: float) -> None:
    pipe, window, number = Pipe(mbit_s, delay_ms), LoadWindow(round(2 * delay_ms * NS_PER_MS), 0), 0
    for now_ns in range(0, 4 * NS_PER_S, NS_PER_MS):
        while pipe.arriving and pipe.arriving[0][0] <= now_ns:
            window.arrived(pipe.arriving.pop(0)[1], now_ns)
        while window.has_room(now_ns):
            window.sent(number, LOAD, now_ns)
            pipe.take(number, now_ns)
            number += 1
    assert window.mbit_s() == pytest.approx(mbit_s, rel=0.1)
    assert pipe.most_waiting_ms < 650.0


def test_load_that_is_lost_makes_room_again() -> None:
    window = LoadWindow(50 * NS_PER_MS, 0)
    for number in range(-(-FIRST_BYTES // LOAD)):
        window.sent(number, LOAD, 0)
    assert not window.has_room(NS_PER_S)
    assert window.has_room(3 * NS_PER_S)
    assert window.mbit_s() == 0.0

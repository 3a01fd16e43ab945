"""The emulated link against its own statement: delay, jitter, loss, rate and queue, on stepped time."""

from random import Random
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_MS, NS_PER_S
from lab.stage.network.link_model import Impairment, LinkModel

MS = NS_PER_MS
PACKETS = 20_000


def link(seed: int, **fields: Any) -> LinkModel:
    return LinkModel(Impairment(**fields), Random(seed))  # noqa: S311  # no secret


def packet(flow: int, number: int, size: int = 1000) -> bytes:
    return bytes(12) + flow.to_bytes(12) + number.to_bytes(4) + bytes(size - 28)


def carried(model: LinkModel, every_ns: int, count: int = PACKETS, flows: int = 1) -> list[tuple[int, int, int]]:
    """Flow, number and delay (ns) of each packet that arrived, in order; one is sent `every_ns`."""
    for number in range(count):
        model.send(packet(number % flows, number), number * every_ns)
    arrived = model.arrived(10**15)
    read = [(int.from_bytes(p[12:24]), int.from_bytes(p[24:28]), due_ns) for due_ns, p in arrived]
    return [(flow, number, due_ns - number * every_ns) for flow, number, due_ns in read]


def test_a_link_without_impairment_delivers_at_once() -> None:
    model = link(1)
    model.send(packet(0, 7), 5)
    assert model.due_ns == 5
    assert model.arrived(4) == []
    assert model.arrived(5) == [(5, packet(0, 7))]
    assert model.due_ns is None


def test_jitter_is_a_normal_distribution_cut_off_at_two_sigmas() -> None:
    model = link(2, delay_ms=40, jitter_ms=8)
    delays_ms = np.array([late_ns for *_, late_ns in carried(model, 20 * MS)]) / MS  # too seldom to wait for another
    assert delays_ms.min() >= 32
    assert delays_ms.max() <= 48
    assert delays_ms.mean() == pytest.approx(40, abs=0.1)
    assert delays_ms.std() == pytest.approx(0.88 * 4, abs=0.1)  # what the cut-off leaves of a sigma of 4


@pytest.mark.parametrize("reorders", [False, True])
def test_each_flow_keeps_its_order_unless_the_link_reorders(reorders: bool) -> None:
    model = link(3, delay_ms=40, jitter_ms=8, reorders=reorders)
    arrived = carried(model, MS, flows=2)
    numbers = {flow: [number for of, number, _ in arrived if of == flow] for flow in (0, 1)}
    assert all((ordered == sorted(ordered)) is not reorders for ordered in numbers.values())
    everything = [number for _, number, _ in arrived]
    assert everything != sorted(everything)  # one flow never waits for another


def test_loss_is_the_fraction_stated_and_packets_are_lost_one_by_one() -> None:
    model = link(4, loss=0.03)
    came = {number for _, number, _ in carried(model, MS)}
    lost = sorted(set(range(PACKETS)) - came)
    assert len(lost) / PACKETS == pytest.approx(0.03, abs=0.004)
    in_a_row = np.mean(np.diff(lost) == 1)
    assert in_a_row == pytest.approx(0.03, abs=0.02)


def test_a_bottleneck_carries_its_rate_and_drops_what_its_queue_does_not_hold() -> None:
    model = link(5, delay_ms=10, mbit_s=20)
    arrived = carried(model, NS_PER_S // 5000)  # 40 Mbit/s
    assert len(arrived) / PACKETS == pytest.approx(0.5, abs=0.02)
    waits_ms = np.array([late_ns for *_, late_ns in arrived]) / MS - 10
    assert waits_ms.min() == pytest.approx(0.4)  # of one packet at 20 Mbit/s
    assert waits_ms.max() == pytest.approx(100.4, abs=0.5)  # the queue


def test_a_slow_bottleneck_holds_64_kb() -> None:
    model = link(6, mbit_s=2)
    arrived = carried(model, MS)
    assert max(late_ns for *_, late_ns in arrived) / MS == pytest.approx(65.536 * 4 + 4, abs=4)


def test_a_packet_that_finds_the_link_idle_does_not_wait() -> None:
    model = link(7, mbit_s=2)
    assert {late_ns for *_, late_ns in carried(model, 5 * MS, 100)} == {4 * MS}


def test_what_is_lost_behind_the_bottleneck_has_taken_its_share_of_the_rate() -> None:
    model = link(8, mbit_s=20, loss=0.5)
    assert len(carried(model, NS_PER_S // 5000)) / PACKETS == pytest.approx(0.25, abs=0.02)


def test_a_cut_takes_what_is_sent_and_what_is_under_way() -> None:
    model = link(9, delay_ms=40)
    impairment = model.impairment
    model.send(packet(0, 1), 0)
    impairment.cut = True
    model.send(packet(0, 2), 10 * MS)
    assert model.arrived(100 * MS) == []
    impairment.cut = False
    model.send(packet(0, 3), 110 * MS)
    assert model.arrived(200 * MS) == [(150 * MS, packet(0, 3))]


def test_doubled_packets_arrive_twice() -> None:
    model = link(10, doubled=0.3)
    assert len(carried(model, MS)) / PACKETS == pytest.approx(1.3, abs=0.02)


def test_packets_under_way_keep_their_time_when_the_delay_changes() -> None:
    model = link(11, delay_ms=120)
    impairment = model.impairment
    model.send(packet(0, 1), 0)
    impairment.delay_ms = 20
    model.send(packet(1, 2), MS)
    assert model.arrived(50 * MS) == [(21 * MS, packet(1, 2))]
    assert model.arrived(120 * MS) == [(120 * MS, packet(0, 1))]

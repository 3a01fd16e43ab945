"""The network between the sites on stepped time, and the figures of the series over it."""

import numpy as np
import pytest

from common.clock import NS_PER_MS
from lab.experiments.placing import over_network
from lab.experiments.placing.judge import Placed
from lab.experiments.placing.network import AGAIN_NS, PACKET_BYTES, Messages, Network, Stream
from lab.experiments.placing.trial import TrialResult

FOR_EVER_NS = 10**12


def rng():
    return np.random.default_rng(5)


def arrivals_ns(way, until_ns=2000 * NS_PER_MS):
    """When each message arrives, by its number."""
    return {number: t for t in range(0, until_ns, NS_PER_MS) for number in way.arrived(t)}


def test_a_message_takes_the_delay_and_its_own_time():
    way = Messages[int](Network(delay_ms=40.0), rng(), own_ns=5 * NS_PER_MS)
    way.send(1, 0)
    assert way.arrived(45 * NS_PER_MS - 1) == []
    assert way.newest is None
    assert way.arrived(45 * NS_PER_MS) == [1]
    assert way.newest == 1
    assert way.takes_ns == 45 * NS_PER_MS


def test_as_many_messages_are_lost_as_the_network_says():
    way = Messages[int](Network(loss=0.03), rng())
    for number in range(10_000):
        way.send(number, 0)
    came = way.arrived(0)
    assert 9600 < len(came) < 9800
    assert came == sorted(came)


def test_a_stream_is_as_quick_as_its_rate():
    network = Network(delay_ms=10.0, mbit_s=2.0)
    way = Stream[int](network, rng())
    for number in range(3):
        way.send(number, 10 * PACKET_BYTES, 0)
    packet_ms = PACKET_BYTES * 8 / 2e3
    came = arrivals_ns(way)
    assert [came[k] / NS_PER_MS for k in range(3)] == pytest.approx(
        [10 + 10 * packet_ms * (k + 1) for k in range(3)], abs=1
    )


def test_nothing_in_a_stream_is_lost_or_out_of_order_and_what_is_lost_takes_a_round_trip_more():
    clean, lossy = (Stream[int](Network(delay_ms=50.0, loss=loss), rng()) for loss in (0.0, 0.2))
    for way in (clean, lossy):
        for number in range(50):
            way.send(number, PACKET_BYTES, number * 20 * NS_PER_MS)
    quick, late = arrivals_ns(clean), arrivals_ns(lossy)
    assert list(late) == list(range(50))
    more = [late[k] - quick[k] for k in late]
    assert min(more) == 0
    assert 100 * NS_PER_MS + AGAIN_NS in more


def test_a_sender_with_a_full_buffer_drops_what_comes():
    way = Stream[int](Network(mbit_s=2.0), rng())
    for number in range(10):
        way.send(number, 20_000, 0)
    assert way.arrived(FOR_EVER_NS) == [0, 1, 2, 3]


@pytest.fixture
def report():
    def end(c):
        placed = Placed(1.0, -2.0, 0.5, c.network.loss == 0)
        return TrialResult(placed, 30.0 + c.network.delay_ms, 0, 1, 3, 0, 0, 20.0, 60.0)

    return over_network.network_report({c: end(c) for c in over_network.network_conditions(quick=True)})


def test_the_report_has_every_network_with_time_and_success(report):
    assert set(report.figures) == set(over_network.NETWORKS)
    assert report.figures["120_ms"]["time_s"]["median"] == 150.0
    assert (report.figures["3_percent_lost"]["placed"], report.figures["2_mbit_s"]["placed"]) == (0, 1)
    assert report.figures["0_ms"]["picture_age_ms"] == 60.0
    assert report.plots["network"].startswith(b"\x89PNG")
    assert "40_ms: placed 1 of 1" in report.summary


def test_every_network_has_ten_trials_from_the_same_places_that_nothing_was_chosen_on():
    conditions = over_network.network_conditions(quick=False)
    by_network = {name: {c.seed for c in conditions if c.network == of} for name, of in over_network.NETWORKS.items()}
    assert len(by_network) == 8
    assert all(seeds == set(range(3001, 3011)) for seeds in by_network.values())

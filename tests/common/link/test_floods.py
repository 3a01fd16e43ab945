"""Floods of messages over real links: what a receiver takes is capped, and nothing that counts is lost to the cap."""

import dataclasses
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import msgspec
import pytest
from structlog.testing import capture_logs

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_S
from common.link.channels import CHANNELS, HAND
from common.link.pubsub import Latest
from common.link.transport import Link, open_link
from common.messages.hand import HandArm
from lab.stage.waiting import until
from tests.common.link.secured_cell import QUIET_S, free_port

CELL = "lab"
FLOOD_HZ = 10_000
LOW_HZ = 2.0  # so that a receiver on a busy machine, too, is fast enough for the cap
DEEP_ENOUGH = 12  # samples in one tick of 4 ms: 3000 a second from another sender


@pytest.fixture
def links() -> Iterator[list[Link]]:
    """A receiver, and two that connect to it."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        receiver = stack.enter_context(open_link(listen=(endpoint,)))
        yield [receiver, *(stack.enter_context(open_link(connect=(endpoint,))) for _ in range(2))]


def sample(seq: int) -> HandArm:
    return msgspec.structs.replace(golden.HAND, seq=seq)


@contextmanager
def flooding(link: Link) -> Iterator[None]:
    stop, publisher = threading.Event(), link.publisher(HAND, CELL, operator="ben")

    def flood() -> None:
        while not stop.wait(0.01):
            for _ in range(FLOOD_HZ // 100):
                publisher.put(golden.HAND)

    thread = threading.Thread(target=flood)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def last_seq(latest: Latest[HandArm]) -> int:
    """The newest sample that waits, 0 without one."""
    return max((s.seq for s in iter(latest.take, None)), default=0)


@pytest.mark.slow
def test_who_listens_takes_no_more_than_the_cap_is_told_of_the_flood_and_hears_the_newest(links: list[Link]) -> None:
    receiver, sender, _ = links
    channel = dataclasses.replace(HAND, rate_hz=LOW_HZ)
    times_ns: list[int] = []
    seqs: list[int] = []

    def take(hand: HandArm, now_ns: int) -> None:
        times_ns.append(now_ns)
        seqs.append(hand.seq)

    with capture_logs() as log:
        threading.Thread(target=receiver.latest(channel, CELL).feed, args=(take,), daemon=True).start()
        begun_ns = time.monotonic_ns()
        with flooding(sender):
            until(lambda: [line for line in log if line["event"] == "too many messages"])
        most = (time.monotonic_ns() - begun_ns) / NS_PER_S * channel.max_hz + channel.depth + 1
        assert len(times_ns) <= most
    assert [line["reason"].split(":")[0] for line in log] == [f"{HAND.key_for(CELL)} is flooded"]
    sender.publisher(HAND, CELL, operator="anna").put(sample(golden.HAND.seq + 1))
    until(lambda: seqs[-1] == golden.HAND.seq + 1)


def test_of_samples_that_delay_has_bunched_the_newest_comes(links: list[Link]) -> None:
    receiver, sender, _ = links
    latest, publisher = receiver.latest(HAND, CELL), sender.publisher(HAND, CELL, operator="anna")
    until(lambda: publisher.put(sample(1)) or last_seq(latest))
    for newest in range(100, 2100, 100):
        for seq in range(newest - 9, newest + 1):
            publisher.put(sample(seq))
        until(lambda: last_seq(latest) == newest)  # noqa: B023  # called here alone


def test_one_operators_flood_leaves_room_for_anothers_sample(links: list[Link]) -> None:
    receiver, rude, polite = links
    control, witness = receiver.latest(HAND, CELL), receiver.latest(HAND, CELL)
    for seq, sender in enumerate((rude, polite), start=1):
        publisher = sender.publisher(HAND, CELL, operator="anna")
        until(lambda: publisher.put(sample(seq)) or last_seq(witness) == seq)  # noqa: B023  # called here alone
    until(lambda: control.take() is None)
    polite.publisher(HAND, CELL, operator="anna").put(sample(7))
    until(lambda: last_seq(witness) == 7)
    flood = rude.publisher(HAND, CELL, operator="anna")
    for seq in range(100, 100 + DEEP_ENOUGH):
        flood.put(sample(seq))
    until(lambda: last_seq(witness) == 99 + DEEP_ENOUGH)
    assert 7 in [hand.seq for hand in iter(control.take, None)]


@pytest.mark.slow
def test_of_listed_operators_none_displaces_anothers_samples_however_many_come(links: list[Link]) -> None:
    receiver, rude, polite = links
    own, others = (receiver.latest(HAND, CELL, operator=name) for name in ("anna", "ben"))
    flood, hers = rude.publisher(HAND, CELL, operator="ben"), polite.publisher(HAND, CELL, operator="anna")
    for publisher, latest in ((hers, own), (flood, others)):
        until(lambda: publisher.put(sample(1)) or last_seq(latest))  # noqa: B023  # called here alone
    time.sleep(QUIET_S)
    last_seq(own)
    hers.put(sample(7))
    with flooding(rude):
        until(lambda: last_seq(others) == golden.HAND.seq)
        time.sleep(QUIET_S)
    assert own.take_named() == ("anna", sample(7))
    assert own.take() is None


def test_no_channels_cap_is_near_its_rate_or_boundless() -> None:
    for channel in CHANNELS:
        assert 5 * channel.rate_hz <= channel.max_hz <= 1000

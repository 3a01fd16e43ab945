"""Requests as they wait at the remote site, over real links: nothing displaces a stop."""

import time
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from common.link.channels import ANY, ENGAGEMENT, HAND, MAINTENANCE, MAINTENANCE_STOP, STOP
from common.link.transport import PENDING_REQUESTS, Link, open_link
from common.messages.codec import encode
from common.messages.hand import ClockSync, HandArm
from common.messages.requests import EngagementAction, EngagementRequest, StopRequest
from common.process.log import RefusalLog
from common.steady_time import HostTime
from lab.stage.waiting import until
from remote_site.runtime.control import MAINTENANCE_NAME, UNHELD_HZ, Inbox
from remote_site.session.lease import Holder, Lease
from remote_site.session.requests import SessionRequest
from tests.common.link.secured_cell import free_port
from tests.remote_site.remote_loop import TICK_NS, hand

CELL = "lab"
APART_S = 0.003  # requests that follow each other immediately are dropped on arrival
ARRIVES_S = 0.2


@pytest.fixture
def links() -> Iterator[list[Link]]:
    """A remote site, an operator and somebody who floods it."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with ExitStack() as stack:
        site = stack.enter_context(open_link(listen=(endpoint,)))
        yield [site, *(stack.enter_context(open_link(connect=(endpoint,))) for _ in range(2))]


def ask(link: Link, key: str, payload: bytes) -> None:
    """Ask without waiting for the answer, which comes when the site is done with its tick."""
    link._session.get(key, payload=payload, timeout=9.0)


def flood(link: Link, key: str) -> None:
    for number in range(2 * PENDING_REQUESTS):
        deadline_ns = time.monotonic_ns() + 5_000_000_000
        request = EngagementRequest(id=number, deadline_ns=deadline_ns, action=EngagementAction.ENGAGE, seen_ns=5)
        ask(link, key, encode(request))
        time.sleep(APART_S)
    time.sleep(ARRIVES_S)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stop", "flooded", "asker"),
    [
        (STOP.key_for(CELL, operator="anna"), ENGAGEMENT.key_for(CELL, operator="ben"), "anna"),
        (STOP.key_for(CELL, operator="anna"), ENGAGEMENT.key_for(CELL, operator="anna"), "anna"),
        (MAINTENANCE_STOP.key_for(CELL), MAINTENANCE.key_for(CELL), MAINTENANCE_NAME),
    ],
)
@pytest.mark.parametrize("listed", [(ANY,), ("anna", "ben")])
def test_a_stop_is_never_displaced_and_comes_first(
    links: list[Link], stop: str, flooded: str, asker: str, listed: tuple[str, ...]
) -> None:
    site, polite, rude = links
    inbox = Inbox(site, CELL, RefusalLog(), listed)
    for link, key in ((polite, stop), (rude, flooded)):
        until(lambda: ask(link, key, b"is anybody there?") or inbox.requests(0) or inbox.refusals.counts)  # noqa: B023
        time.sleep(ARRIVES_S)
        until(lambda: not inbox.requests(0) and not inbox.refusals.counts.pop("malformed", 0))
    ask(polite, stop, encode(StopRequest()))
    time.sleep(ARRIVES_S)
    flood(rude, flooded)
    waiting = [request for request, _ in inbox.requests(time.monotonic_ns())]
    assert len(waiting) == 2
    assert waiting[0] == SessionRequest(EngagementAction.STOP, asker, maintenance=asker == MAINTENANCE_NAME)
    assert (waiting[1].action, waiting[1].seen_ns) == (EngagementAction.ENGAGE, 5)


@pytest.mark.slow
def test_the_offset_in_a_sample_is_led_on_by_what_this_clock_was_slewed_since(links: list[Link]) -> None:
    site, operator, _ = links
    inbox = Inbox(site, CELL, RefusalLog(), ("anna",), read_clocks=lambda: HostTime(10**9, 5_000))
    clock = ClockSync(remote_minus_local_ns=70, uncertainty_ns=3, measured_ns=10_000, remote_ahead_ns=1_000)
    hands, came = operator.publisher(HAND, CELL, operator="anna"), []

    def arrives() -> bool:
        hands.put(hand(1, 1, clock=clock))
        came.extend(inbox.samples(None, time.monotonic_ns()))
        return bool(came)

    until(arrives)
    now = came[0].sample.clock
    assert now is not None
    assert (now.remote_minus_local_ns, now.measured_ns) == (70 - 4_000, 6_000)


class Sender:
    """Stands for the link of a site to which one operator's hand samples come, so many each tick."""

    def __init__(self, each_tick: int) -> None:
        self.each_tick, self._left = each_tick, 0

    def tick(self) -> None:
        self._left = self.each_tick

    def latest(self, *_given: object, operator: str) -> "Sender":
        self._operator = operator
        return self

    def take_named(self) -> tuple[str, HandArm] | None:
        self._left -= 1
        return (self._operator, hand(1, 1)) if self._left >= 0 else None

    def serve(self, *_given: object, **_named: object) -> None:
        """No request comes."""

    answer = serve


@pytest.mark.parametrize(
    ("holder", "each_tick", "every", "fewest", "most"),
    [
        ("ben", 16, 1, 16 * 2500, 16 * 2500),
        ("anna", 16, 1, UNHELD_HZ * 10, UNHELD_HZ * 10 + HAND.depth),
        ("", 16, 1, UNHELD_HZ * 10, UNHELD_HZ * 10 + HAND.depth),
        ("anna", 1, 4, 625, 625),  # as many as cameras take
    ],
)
def test_of_an_operator_without_the_lease_no_flood_of_samples_is_taken(
    holder: str, each_tick: int, every: int, fewest: int, most: int
) -> None:
    sender, refusals, taken = Sender(each_tick), RefusalLog(), 0
    inbox = Inbox(sender, CELL, refusals, ("ben",))  # type: ignore[arg-type]  # a stand-in
    lease = Lease(41, Holder(7, holder), 10**12) if holder else None
    for tick in range(2500):
        if tick % every == 0:
            sender.tick()
        taken += len(inbox.samples(lease, tick * TICK_NS))
    assert fewest <= taken <= most
    assert refusals.counts["too_many"] == each_tick * 2500 // every - taken

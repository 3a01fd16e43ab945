"""Lanes: copies of hand samples on connections of their own, which no window holds back; each sample counts once."""

import time
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest

from common.link.access import Serves, access_control
from common.link.channels import HAND, STATE
from common.link.lanes import COPIES, LANES, REMEMBERED, Copies, LanePublisher
from common.link.pubsub import Latest
from common.link.roles import Identity, Role
from common.link.transport import open_link
from common.messages.codec import encode
from lab.stage.waiting import until
from tests.common.link.secured_cell import ANNA, CELL, HAND_SAMPLE, Cell, running, secured

PERIOD_MS, SAMPLE_BYTES = 33, 210
PACKET_BYTES = 1200  # the least that QUIC's congestion control counts with
ACK_DELAY_MS = 25


@dataclass
class Connection:
    """QUIC's congestion control after losses: a window of two packets, of which a whole one has to be free to send."""

    round_trip_ms: int
    waiting: list[int] = field(default_factory=list)
    longest_ms: int = 0
    _in_flight: list[tuple[int, int]] = field(default_factory=list)  # until when (ms), bytes

    def step(self, now_ms: int) -> None:
        self._in_flight = [(until_ms, size) for until_ms, size in self._in_flight if until_ms > now_ms]
        if self.waiting and sum(size for _, size in self._in_flight) + PACKET_BYTES < 2 * PACKET_BYTES:
            self.longest_ms = max(self.longest_ms, now_ms - self.waiting[0])
            self._in_flight.append((now_ms + self.round_trip_ms + ACK_DELAY_MS, SAMPLE_BYTES * len(self.waiting)))
            self.waiting.clear()


@dataclass
class Taker:
    """Stands for a lane's publisher."""

    taken: list[bytes] = field(default_factory=list)

    def put(self, payload: bytes) -> None:
        self.taken.append(payload)


def neighbours(cell: Cell) -> int:
    """How many sessions are connected to the cell's."""
    return len(cell.link._session.info.peers_zid())


def longest_wait_ms(connections: int, copies: int, round_trip_ms: int) -> int:
    """The longest that a copy waits in half a minute, those of each sample going on connections in turn."""
    lanes = [Connection(round_trip_ms) for _ in range(connections)]
    for now_ms in range(30_000):
        if now_ms % PERIOD_MS == 0:
            for k in range(copies):
                lanes[(copies * (now_ms // PERIOD_MS) + k) % connections].waiting.append(now_ms)
        for lane in lanes:
            lane.step(now_ms)
    return max(lane.longest_ms for lane in lanes)


@pytest.mark.parametrize("round_trip_ms", [240, 290, 350])
def test_on_a_long_way_with_losses_samples_wait_on_one_connection_and_never_in_lanes(round_trip_ms: int) -> None:
    assert longest_wait_ms(1, 1, round_trip_ms) > 2 * PERIOD_MS
    assert longest_wait_ms(LANES, COPIES, round_trip_ms) == 0


def test_lanes_lead_to_the_remote_site_alone_since_a_router_would_send_copies_on_by_one_connection() -> None:
    anna = Identity(Role.OPERATOR, CELL, ANNA)
    beside, lane = (access_control(anna, (), routed=False, plain=False, serves=s) for s in (Serves.SITES, Serves.LANE))
    assert {subject["id"] for subject in beside["subjects"]} > {f"router.{CELL}"}
    assert [subject["id"] for subject in lane["subjects"]] == [f"remote.{CELL}"]


def test_lanes_take_turns_by_two() -> None:
    takers = [Taker() for _ in range(4)]
    publisher = LanePublisher(takers)  # type: ignore[arg-type]  # stand-ins
    for k in range(7):
        publisher.put(bytes([k]))
    taken = [[payload[0] for payload in taker.taken] for taker in takers]
    assert taken == [[0, 2, 4, 6], [0, 2, 4, 6], [1, 3, 5], [1, 3, 5]]


def test_a_copy_is_known_by_every_byte_and_for_two_seconds() -> None:
    copies = Copies()
    assert not copies.is_copy(b"one")
    assert copies.is_copy(b"one")
    assert not copies.is_copy(b"one ")
    for k in range(REMEMBERED):
        assert not copies.is_copy(b"%d" % k)
    assert not copies.is_copy(b"one")


class Flood:
    """Stands for a subscription to which copies come faster than they are taken."""

    def __init__(self) -> None:
        self.taken = 0
        self._sample = SimpleNamespace(key_expr=HAND.key_for(CELL, operator=ANNA), payload=self)

    def to_bytes(self) -> bytes:
        return encode(HAND_SAMPLE)

    def try_recv(self) -> SimpleNamespace:
        self.taken += 1
        return self._sample


def test_a_flood_of_copies_keeps_nobody_who_takes_samples() -> None:
    flood = Flood()
    hand = Latest(flood, HAND)  # type: ignore[arg-type]  # a stand-in
    assert hand.take() == HAND_SAMPLE
    assert hand.take() is None
    assert flood.taken == 1 + HAND.depth


def test_each_sample_counts_once_however_many_connections_bring_it(pki: Path) -> None:
    with running(secured(pki, "remote"), "quic") as cell:
        security = secured(pki, "operator.anna")
        with open_link(connect=(cell.endpoint,), security=security, in_lanes=True) as link:
            hand, state = link.publisher(HAND, CELL, operator=ANNA), link.latest(STATE, CELL)
            until(lambda: hand.put(HAND_SAMPLE) or cell.hands)
            until(state.take)
            until(lambda: neighbours(cell) == 1 + LANES)
            before = cell.hands
            for k in range(1, 21):
                hand.put(msgspec.structs.replace(HAND_SAMPLE, seq=HAND_SAMPLE.seq + k))
                time.sleep(0.01)
            until(lambda: cell.hands >= before + 20)
            time.sleep(0.1)
            assert cell.hands == before + 20
        until(lambda: neighbours(cell) == 0)


def test_by_tls_there_are_no_lanes(pki: Path) -> None:
    with running(secured(pki, "remote")) as cell:
        security = secured(pki, "operator.anna")
        with open_link(connect=(cell.endpoint,), security=security, in_lanes=True) as link:
            hand = link.publisher(HAND, CELL, operator=ANNA)
            until(lambda: hand.put(HAND_SAMPLE) or cell.hands)
            assert neighbours(cell) == 1

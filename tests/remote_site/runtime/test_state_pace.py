"""States are sent as often as a long link always carries them, and a change immediately."""

import pytest

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.robot import SessionState
from remote_site.reasons import Code
from remote_site.runtime.reporting import HEADER_BYTES, LEAST_WINDOW_BYTES, UNKNOWN_MS, StatePace

FOLLOWS = SessionState.ENGAGED, Code.OK, 0
HOLDS = SessionState.HOLDING, Code.STALE, 0
STOPPED, STOPPED_AGAIN = ((SessionState.DISENGAGED, Code.STOPPED, halted_ns) for halted_ns in (1, 2))
TICKS_NS = range(0, 10 * NS_PER_S, 20 * NS_PER_MS)


def sent_bytes(network_ms: float | None, payload_bytes: int) -> list[int]:
    pace, sent = StatePace(), []
    for now_ns in TICKS_NS:
        if pace.is_due(now_ns, FOLLOWS, network_ms):
            pace.sent(payload_bytes)
            sent.append(payload_bytes + HEADER_BYTES)
    return sent


@pytest.mark.parametrize("network_ms", [0.0, 0.5, 15.0, 20.0])
def test_a_short_link_gets_every_state(network_ms: float | None) -> None:
    assert len(sent_bytes(network_ms, 650)) == len(TICKS_NS)


@pytest.mark.parametrize("payload_bytes", [300, 650, 1600])
@pytest.mark.parametrize("network_ms", [60.0, 90.0, 120.0, 200.0, None])
def test_a_long_link_and_one_not_known_yet_get_what_two_packets_per_round_trip_carry(
    network_ms: float | None, payload_bytes: int
) -> None:
    round_trips = 10 * 1e3 / (2 * (UNKNOWN_MS if network_ms is None else network_ms))
    used = sum(sent_bytes(network_ms, payload_bytes)) / round_trips / LEAST_WINDOW_BYTES
    assert 0.5 <= used <= 0.85


@pytest.mark.parametrize(("before", "after"), [(FOLLOWS, HOLDS), (STOPPED, STOPPED_AGAIN)])
def test_a_change_and_a_stop_behind_another_one_are_sent_immediately_and_once(
    before: tuple[SessionState, Code, int], after: tuple[SessionState, Code, int]
) -> None:
    pace = StatePace()
    assert pace.is_due(0, before, 120.0)
    pace.sent(650)
    assert not pace.is_due(20 * NS_PER_MS, before, 120.0)
    assert pace.is_due(40 * NS_PER_MS, after, 120.0)
    assert not pace.is_due(60 * NS_PER_MS, after, 120.0)

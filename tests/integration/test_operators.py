"""Two operators at one cell, as real processes: one operates, the other waits until the lease has expired."""

import time
from itertools import count

import msgspec
import pytest

from common.errors import TransportError
from common.link.channels import HAND
from common.messages.requests import OperatorAction
from common.messages.robot import SessionState
from farhand.authority.engage import request_engage
from farhand.authority.lease import act_on_lease, describe_lease, seen_state
from farhand.loopback.site_process import free_ports
from tests.integration.pair import Pair
from tests.integration.sites import CELL, Sites, killed


def holder(sites: Sites) -> str | None:
    return sites.state.lease.holder if sites.state.lease is not None else None


@pytest.mark.long
def test_a_second_operator_takes_over_only_when_the_firsts_lease_has_expired(pair: Pair) -> None:
    _, anna = pair.following()
    sites = pair.sites
    bens_listen = f"tcp/127.0.0.1:{free_ports(1)[0]}"
    ben = sites.local("authority.operator=ben", f"links.listen={bens_listen}")
    assert holder(sites) == "anna"
    clock = sites.state.clock
    assert clock is not None
    assert abs(clock.remote_minus_local_ns) <= clock.uncertainty_ns

    sites.wait("ben to be refused", lambda: any("not_holder" in line and "anna (site" in line for line in ben.lines))
    sites.wait("ben's samples to be fenced", lambda: sites.state.rejected.get("not_holder", 0) > 10)
    with pytest.raises(TransportError, match=r"not_holder\): anna \(site [0-9a-f]+\) holds"):
        request_engage(CELL, sites.endpoints.control, "ben")
    assert holder(sites) == "anna"

    lease = sites.state.lease
    assert lease is not None
    last = next(hand for hand in reversed(sites.record.hands) if hand.lease == lease.number)
    still = killed(anna, sites).lease
    assert still is not None
    assert still.holder == "anna"
    sites.wait("the lease to expire", lambda: holder(sites) is None)
    assert "nobody holds the lease" in describe_lease(seen_state(CELL, sites.endpoints.control))

    assert act_on_lease(CELL, bens_listen, "ben", OperatorAction.TAKE) == "the lease of this cell is yours"
    sites.wait("ben's lease", lambda: holder(sites) == "ben")
    sites.wait("ben to be ready", lambda: sites.state.readiness.ready)
    assert sites.is_in(SessionState.DISENGAGED)
    request_engage(CELL, sites.endpoints.control, "ben")
    sites.wait("ben to be engaged", lambda: sites.is_in(SessionState.ENGAGED))

    seen = len(sites.record.states)
    late = sites.link.publisher(HAND, CELL, operator="anna")
    further = count(last.seq + 1)

    def fenced() -> bool:
        late.put(msgspec.structs.replace(last, seq=next(further), capture_ns=time.monotonic_ns()))
        return sites.state.rejected.get("old_lease", 0) > 10

    sites.wait("late samples to be fenced", fenced)
    ours = sites.state.lease
    assert ours is not None
    assert ours.number > lease.number
    obeyed = {state.obeyed.session for state in sites.record.states[seen:] if state.obeyed is not None}
    assert obeyed == {ours.session}
    ben.end()

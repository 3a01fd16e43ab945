"""Sites that die, come back, or are fed nonsense: the arm stops by the rules and starts only when engaged again."""

import os
import signal
import time

import numpy as np
import pytest

from common.link.channels import HAND
from common.messages.robot import SessionState
from tests.integration.pair import Pair
from tests.integration.sites import (
    CELL,
    Sites,
    alive,
    child_of,
    descendants,
    killed,
)

STOP_S = 30.0  # that it comes, not how soon, which a busy machine decides
STATES = 25  # half a second of them


def at_rest(sites: Sites) -> bool:
    commanded = [state.q_commanded for state in sites.record.states[-10:]]
    return all(q == commanded[0] for q in commanded)


def stays_disengaged(sites: Sites) -> bool:
    """Whether nothing engages although nothing is missing any more."""
    sites.wait("readiness", lambda: sites.state.readiness.ready)
    seen = len(sites.record.states)
    sites.wait("more states", lambda: len(sites.record.states) > seen + STATES)
    return all(state.state is SessionState.DISENGAGED for state in sites.record.states[seen:])


@pytest.mark.slow
def test_a_random_payload_is_counted_and_moves_nothing(pair: Pair) -> None:
    pair.untouched_remote()
    sites = pair.sites
    publisher = sites.link.publisher(HAND, CELL, operator="anna")
    before = sites.state.q_commanded
    deadline = time.monotonic() + 20
    while not sites.state.rejected.get("malformed") and time.monotonic() < deadline:
        publisher._publisher.put(os.urandom(64))
        publisher._publisher.put(b"\xff" * 10_000)
        time.sleep(0.02)
    assert sum(sites.state.rejected.values()) >= 1
    assert set(sites.state.rejected) <= {"malformed", "oversized"}
    assert sites.state.q_commanded == before
    assert sites.is_in(SessionState.DISENGAGED)


@pytest.mark.slow
def test_control_that_stumbles_before_an_engagement_goes_on_by_itself(pair: Pair) -> None:
    remote = pair.untouched_remote()
    sites = pair.sites
    control = child_of(remote, "farhand-control")
    os.kill(control, signal.SIGSTOP)
    time.sleep(0.8)
    os.kill(control, signal.SIGCONT)
    sites.wait("the driver's process to say so", lambda: any("code=command_timeout" in x for x in remote.lines))
    assert not sites.is_in(SessionState.FAULT)
    pair.local()
    sites.wait("the arm to be engaged", lambda: sites.is_in(SessionState.ENGAGED))


def test_a_killed_local_site_stops_the_arm_until_it_is_engaged_anew(pair: Pair) -> None:
    remote, local = pair.moving()
    sites = pair.sites

    assert "old" in killed(local, sites).reason
    told = "state=disengaged code=latched"
    sites.wait("the remote site to say so", lambda: any(told in line for line in remote.lines), STOP_S)
    sites.wait("rest", lambda: at_rest(sites), STOP_S)
    stopped_at = sites.state.q_commanded

    known = {hand.session for hand in sites.record.hands}
    pair.local()
    sites.wait("a new hand", lambda: sites.record.hands[-1].session not in known)
    assert stays_disengaged(sites)
    assert sites.state.q_commanded == stopped_at

    seen = len(sites.record.states)
    sites.wait("the answer to a request", lambda: pair.engage().startswith("engaged"), 20)
    sites.wait("the arm to be engaged", lambda: sites.is_in(SessionState.ENGAGED))
    first = next(state for state in sites.record.states[seen:] if state.state is SessionState.ENGAGED)
    assert np.abs(np.subtract(first.q_commanded, stopped_at)).max() < 0.02


@pytest.mark.slow
def test_a_killed_control_process_is_named_and_nothing_moves_until_it_is_engaged_anew(pair: Pair) -> None:
    remote, local = pair.moving()
    sites = pair.sites
    children = descendants(remote.pid)
    os.kill(child_of(remote, "farhand-control"), signal.SIGKILL)
    sites.wait("the remote site to end", lambda: remote.exit_code is not None, STOP_S)
    assert remote.exit_code == 1
    assert "control died" in remote.last_error()
    sites.wait("the local site to say so", lambda: any("silent" in line for line in local.lines), STOP_S)
    sites.wait("no process to be left", lambda: not any(alive(p) for p in children), STOP_S)

    again = pair.remote()
    assert stays_disengaged(sites)
    assert any("did not end in order" in line for line in again.lines)

"""Sites that die, come back, or are fed nonsense: the arm stops by the rules and starts only when engaged anew."""

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from sites import CELL, Sites, alive, descendants, running_sites

from common.channels import HAND
from common.errors import TransportError
from common.messages import SessionState
from farhand.engage import request_engage

LATCH_AND_STOP_S = 1.5


@pytest.fixture
def sites() -> Iterator[Sites]:
    with running_sites() as sites:
        yield sites


def name_of(pid: int) -> str:
    return Path(f"/proc/{pid}/comm").read_text().strip()


def speed(sites: Sites) -> float:
    """The fastest joint between the last two states, rad/s."""
    last, newest = sites.record.states[-2:]
    seconds = (newest.t_ns - last.t_ns) / 1e9
    return float(np.abs(np.subtract(newest.q, last.q)).max()) / seconds if seconds > 0 else 0.0


def at_rest(sites: Sites) -> bool:
    commanded = [state.q_commanded for state in sites.record.states[-10:]]
    return all(q == commanded[0] for q in commanded)


def wait_until_it_moves(sites: Sites) -> None:
    sites.wait("the arm to be engaged", lambda: sites.is_in(SessionState.ENGAGED))
    sites.wait("the arm to move", lambda: speed(sites) > 0.05)


@pytest.mark.parametrize("driver", ["simulated", "kinematic"])
def test_a_killed_local_site_stops_the_arm_until_it_is_engaged_anew(sites: Sites, driver: str) -> None:
    remote = sites.remote(f"driver.name={driver}")
    local = sites.local()
    wait_until_it_moves(sites)

    os.kill(local.pid, signal.SIGKILL)
    sites.wait("the latch", lambda: sites.is_in(SessionState.DISENGAGED), LATCH_AND_STOP_S)
    sites.wait("the remote site to say so", lambda: any("state=disengaged code=latched" in x for x in remote.lines), 2)
    assert "old" in sites.state.reason
    sites.wait("rest", lambda: at_rest(sites), LATCH_AND_STOP_S)
    stopped_at = sites.state.q_commanded

    sites.local()
    sites.wait("a new hand", lambda: len({hand.session for hand in sites.record.hands}) == 2)
    sites.wait("tracking", lambda: sites.record.hands[-1].seq > 60)
    assert sites.is_in(SessionState.DISENGAGED)
    assert sites.state.q_commanded == stopped_at

    deadline = time.monotonic() + 20
    engaged = ""
    while not engaged and time.monotonic() < deadline:
        engaged = try_to_engage(sites)
    assert engaged.startswith("engaged")
    sites.wait("the arm to be engaged", lambda: sites.is_in(SessionState.ENGAGED), 5)
    assert np.abs(np.subtract(sites.state.q_commanded, stopped_at)).max() < 0.02


def try_to_engage(sites: Sites) -> str:
    try:
        return request_engage(CELL, sites.control)
    except TransportError:
        return ""


def test_a_killed_control_process_is_named_and_its_robot_stops_by_itself(sites: Sites) -> None:
    remote = sites.remote()
    local = sites.local()
    wait_until_it_moves(sites)
    children = descendants(remote.pid)
    control = next(p for p in children if name_of(p) == "farhand-control")
    os.kill(control, signal.SIGKILL)
    sites.wait("the remote site to end", lambda: remote.exit_code is not None, 5)
    assert remote.exit_code == 1
    assert "control died" in remote.last_error()
    sites.wait("the local site to say so", lambda: any("silent" in line for line in local.lines), 2)
    sites.wait("no process to be left", lambda: not any(alive(p) for p in children), 3)

    again = sites.remote()
    seen = len(sites.record.hands)
    sites.wait("a tracked hand", lambda: len(sites.record.hands) > seen + 60)
    assert sites.is_in(SessionState.DISENGAGED)
    assert any("did not end in order" in line for line in again.lines)


def test_control_that_stumbles_before_an_engagement_goes_on_by_itself(sites: Sites) -> None:
    remote = sites.remote()
    control = next(p for p in descendants(remote.pid) if name_of(p) == "farhand-control")
    os.kill(control, signal.SIGSTOP)
    time.sleep(0.8)
    os.kill(control, signal.SIGCONT)
    sites.wait("the driver's process to say so", lambda: any("code=command_timeout" in x for x in remote.lines), 5)
    assert not sites.is_in(SessionState.FAULT)
    sites.local()
    sites.wait("the arm to be engaged", lambda: sites.is_in(SessionState.ENGAGED))


def test_a_random_payload_is_counted_and_moves_nothing(sites: Sites) -> None:
    sites.remote()
    publisher = sites.link.publisher(HAND, CELL)
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


def test_both_sites_end_within_two_seconds_of_sigterm_and_leave_nothing(sites: Sites) -> None:
    processes = [sites.remote(), sites.local()]
    wait_until_it_moves(sites)
    started = [p for site in processes for p in (site.pid, *descendants(site.pid))]
    for site in processes:
        os.kill(site.pid, signal.SIGTERM)
    sites.wait("both to end", lambda: all(site.exit_code is not None for site in processes), 3)
    assert [site.exit_code for site in processes] == [0, 0]
    sites.wait("no process to be left", lambda: not any(alive(p) for p in started), 1)

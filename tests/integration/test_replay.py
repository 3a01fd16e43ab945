"""Both sites as real processes for 20 s, with requests and faults: every command comes again when it is replayed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from common.config.loading import load_config
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from farhand.authority.engage import request_engage, request_maintenance
from farhand.loopback.site_process import options_of
from remote_site.config import RemoteConfig
from tests.integration.sites import CELL, LIGHT_REMOTE, PATIENT, Sites, descendants, name_of, running_sites
from tests.remote_site.teleop.cycle_log import first_difference, read_cycles

SECONDS = 20.0
PAUSE_S = 0.6  # between T_soft and T_latch of the patient sites
OPERATOR = "anna"
SCRIPT = Path(__file__).with_name("recording_remote.py")
SETTINGS = ("driver.name=kinematic", *LIGHT_REMOTE, *PATIENT)


def paused(pid: int, seconds: float) -> None:
    """Stop a process for a while."""
    os.kill(pid, signal.SIGSTOP)
    time.sleep(seconds)
    os.kill(pid, signal.SIGCONT)


def maintain(sites: Sites, action: EngagementAction) -> None:
    request_maintenance(CELL, sites.endpoints.control, action, print)


def engage(sites: Sites) -> None:
    """Ask until the arm follows."""
    sites.wait("readiness", lambda: sites.state.readiness.ready)
    request_engage(CELL, sites.endpoints.control, OPERATOR)
    sites.wait("the arm to be engaged", lambda: sites.is_in(SessionState.ENGAGED))


def follow_again(sites: Sites) -> None:
    """Wait until the arm follows; a machine that was late has ended the engagement, so ask for another one then."""

    def follows() -> bool:
        if sites.is_in(SessionState.DISENGAGED) and sites.state.readiness.ready:
            request_engage(CELL, sites.endpoints.control, OPERATOR)
        return sites.is_in(SessionState.ENGAGED)

    sites.wait("the arm to follow again", follows)


def operate(sites: Sites, remote: int, local: int) -> None:
    """Follow the hand; then a stop, a driver that is silent, and a hand that is gone for a while."""
    engage(sites)
    time.sleep(3.0)
    maintain(sites, EngagementAction.STOP)
    sites.wait("the stop", lambda: sites.is_in(SessionState.DISENGAGED))
    maintain(sites, EngagementAction.RESET)
    engage(sites)
    time.sleep(2.0)
    follow_again(sites)
    paused(next(pid for pid in descendants(remote) if name_of(pid) == "farhand-driver"), 0.5)
    sites.wait("the fault", lambda: sites.is_in(SessionState.FAULT))
    maintain(sites, EngagementAction.RESET)
    engage(sites)
    time.sleep(2.0)
    follow_again(sites)
    paused(local, PAUSE_S)
    follow_again(sites)


@pytest.mark.long
def test_every_command_of_a_run_comes_again_bit_for_bit(tmp_path: Path) -> None:
    log = tmp_path / "cycles"
    with running_sites() as sites:
        settings = (*sites.endpoints.remote, *SETTINGS)
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path), "STATE_DIRECTORY": str(tmp_path)}
        remote = subprocess.Popen([sys.executable, str(SCRIPT), str(log), *options_of(settings)], env=environment)
        try:
            local = sites.local(f"authority.operator={OPERATOR}")
            sites.wait_for_states()
            began_s = time.monotonic()
            operate(sites, remote.pid, local.pid)
            time.sleep(max(SECONDS - (time.monotonic() - began_s), 0.0))
        finally:
            remote.terminate()
            remote.wait(60)
    with log.open("rb") as stream:
        cycles = list(read_cycles(stream))
    assert len(cycles) > SECONDS * 125 / 2
    states = {command.snapshot.state for _, command in cycles}
    assert states == set(SessionState)
    assert {request.action for given, _ in cycles for request in given.requests} == {
        EngagementAction.STOP,
        EngagementAction.RESET,
        EngagementAction.ENGAGE,
    }
    assert first_difference(load_config(RemoteConfig, None, settings), cycles) == ""

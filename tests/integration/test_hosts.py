"""Two hosts whose clocks differ by an hour, as real processes: holding the key down moves the arm."""

import subprocess
import threading
import time
from collections.abc import Iterator

import pytest

from common.clock import NS_PER_S
from common.link.channels import INTENT
from common.messages.hand import Intent, OperatorIntent
from common.messages.robot import SessionState
from tests.integration.sites import (
    CELL,
    PATIENT,
    Sites,
    running_sites,
)

APART_S = 3600
IN_ANOTHER_TIME = ["unshare", "-T", "--monotonic", str(APART_S)]


@pytest.fixture
def sites() -> Iterator[Sites]:
    with running_sites() as sites:
        yield sites


def in_another_time() -> bool:
    """Whether this machine lets a process have a monotonic clock of its own."""
    return subprocess.run([*IN_ANOTHER_TIME, "true"], check=False, capture_output=True).returncode == 0


class Console:
    """Sends the operator's intent at 50 Hz, by the clock of the local site."""

    def __init__(self, sites: Sites) -> None:
        self.held: bool | None = False
        self._publisher = sites.link.publisher(INTENT, CELL, operator="anna")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def __enter__(self) -> "Console":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stop.wait(0.02):
            if self.held is not None:
                sent_ns = time.monotonic_ns() + APART_S * NS_PER_S
                self._publisher.put(OperatorIntent(session=1, sent_ns=sent_ns, intent=Intent(hold=self.held)))


@pytest.mark.long
@pytest.mark.skipif(not in_another_time(), reason="no right to a time namespace")
def test_hold_to_run_between_hosts_whose_clocks_differ_by_an_hour(sites: Sites) -> None:
    sites.remote("driver.name=kinematic", "engagement.mode=hold_to_run", *PATIENT)
    sites.local("authority.operator=anna", within=IN_ANOTHER_TIME)
    with Console(sites) as console:
        sites.wait_for_states()
        sites.wait("readiness", lambda: sites.state.readiness.ready)
        clock = sites.state.clock
        assert clock is not None
        assert abs(clock.remote_minus_local_ns + APART_S * NS_PER_S) <= clock.uncertainty_ns
        assert sites.is_in(SessionState.DISENGAGED)
        assert not sites.state.readiness.held

        console.held = True
        sites.wait("the arm to follow", lambda: sites.is_in(SessionState.ENGAGED))
        assert "future" not in sites.state.rejected
        console.held = False
        sites.wait("the stop", lambda: sites.is_in(SessionState.DISENGAGED))
        assert sites.state.code == "let_go"
        console.held = True
        sites.wait("the arm to follow again", lambda: sites.is_in(SessionState.ENGAGED))

        console.held = None
        sites.wait("the stop after the console's last word", lambda: sites.is_in(SessionState.DISENGAGED))
        console.held = True
        sites.wait("the key to be seen", lambda: sites.state.readiness.ready)
        time.sleep(0.5)
        assert sites.is_in(SessionState.DISENGAGED)
        console.held = False
        time.sleep(0.2)
        console.held = True
        sites.wait("a new press to count", lambda: sites.is_in(SessionState.ENGAGED))

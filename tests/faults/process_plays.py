"""Processes that die while the arm moves: control, the whole remote site, the page whose key is held."""

import os
import signal
import time

from common.messages.robot import SessionState
from tests.faults.cell_pair import CellPair
from tests.faults.command_socket import send
from tests.faults.trial import Trial
from tests.integration.sites import child_of

WATCHDOG_MS = 200.0  # of the A465's controller


def kill_control(trial: Trial) -> None:
    """Control is killed: the driver's process stops the arm, and what starts again is not engaged."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.kill(child_of(pair.remote, "farhand-control"), signal.SIGKILL))
    trial.rests()
    pair.wait("the remote site to end", lambda: pair.remote.exit_code is not None, 10)
    trial.check("control" in "".join(pair.remote.lines), "the site does not name the dead process")
    _start_again(trial)


def kill_remote(trial: Trial) -> None:
    """All processes of the remote site are killed: the robot's own watchdog stops it."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.killpg(pair.remote.pid, signal.SIGKILL))
    trial.rests(stop_within_s=WATCHDOG_MS / 1e3)
    _start_again(trial)


def _start_again(trial: Trial) -> None:
    trial.pair.start_remote()
    trial.pair.wait("a good hand", lambda: trial.pair.state.readiness.ready)
    trial.stays()


def close_page(trial: Trial) -> None:
    """The page whose key is held is killed: the arm stops, and a new page with the key down moves nothing."""
    pair, port = trial.pair, trial.pair.start_console()
    page = pair.start_page(port)
    pair.wait("readiness", lambda: pair.state.readiness.ready)
    pair.wait("the key to count as released", lambda: _presses(pair))
    pair.move()
    trial.begin(lambda _: os.kill(page.pid, signal.SIGKILL))
    trial.latches(0.5)
    trial.rests(stop_within_s=0.5)
    pair.start_page(port)
    send(pair.folder / "page", down=True)
    trial.stays(2.0)


def _presses(pair: CellPair) -> bool:
    """Release the page's key for a while, press it, and report whether the arm follows."""
    for down in (False, True):
        send(pair.folder / "page", down=down)
        time.sleep(0.7)
    return pair.is_in(SessionState.ENGAGED)

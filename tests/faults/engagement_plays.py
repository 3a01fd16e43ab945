"""Engagements that nobody asked for: after a reset, a failed start, a hold without end, a hand that comes late."""

import os
import signal
import time

from bench.network.command_socket import send
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from tests.faults.acts import hand
from tests.faults.cell_pair import CellPair
from tests.faults.process_plays import press_until_engaged, start_again
from tests.faults.trial import Trial
from tests.integration.sites import child_of

PRESSED_S = 0.7
EXPIRES_S = 61.0


def reset_under_key(trial: Trial) -> None:
    """Stopped, the operator releases the key and presses it again; the reset then moves nothing."""
    pair, port = trial.pair, trial.pair.start_console()
    pair.start_page(port)
    pair.wait("readiness", lambda: pair.state.readiness.ready)
    pair.wait("the key to count as released", lambda: press_until_engaged(pair))
    pair.move()
    trial.begin(lambda pair: pair.ask(EngagementAction.STOP))
    trial.rests(stop_within_s=0.1)
    for down in (False, True):
        send(pair.folder / "page", down=down)
        time.sleep(PRESSED_S)
    trial.check(pair.ask(EngagementAction.RESET).done, "the reset was refused")
    pair.wait("a good hand", lambda: pair.state.readiness.ready)
    trial.stays(2.0)
    pair.wait("an engagement by a new press", lambda: press_until_engaged(pair), 10)


def kill_video(trial: Trial) -> None:
    """The video process is killed in the mode automatic: the site ends, and the next start engages nothing."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.kill(child_of(pair.remote, "farhand-video"), signal.SIGKILL))
    pair.wait("the remote site to end", lambda: pair.remote.exit_code is not None, 10)
    trial.check("process video died" in pair.state.reason, f"the last state names no cause: {pair.state.reason}")
    trial.rests(stop_within_s=0.5)
    start_again(trial)


def trickle(trial: Trial) -> None:
    """Samples too far apart to be followed hold the arm, and end the engagement after the longest hold."""
    pair = trial.pair
    pair.move()
    trial.begin(hand(camera="slow"))
    trial.rests()
    longest_s = pair.config.safety.longest_hold_ms / 1e3
    trial.check(pair.is_in(SessionState.HOLDING), f"it does not hold: {pair.state.reason}")
    trial.latches(longest_s + 0.5)
    trial.check("held for" in pair.state.reason, f"the reason does not name the hold: {pair.state.reason}")
    pair.hand(camera="")
    trial.stays()


def late_hand(trial: Trial) -> None:
    """The first hand comes more than a minute after both sites were ready, in the mode automatic."""
    pair = trial.pair
    pair.hand(lost=True)
    pair.start_remote()
    trial.begin(_nothing)
    trial.rested_ns = trial.fault_ns
    pair.wait("the lease", lambda: pair.state.lease is not None)
    time.sleep(EXPIRES_S)
    pair.hand(lost=False)
    pair.wait("a good hand", lambda: pair.state.readiness.ready)
    trial.stays(2.0)
    trial.check("expired" in pair.state.reason, f"the reason is not the expiry: {pair.state.reason}")
    pair.engage()


def _nothing(_: CellPair) -> None:
    pass

"""Engagements that nobody asked for: after a reset, a failed start, a hold without end, a hand that comes late."""

import os
import signal
import time

from common.link.engagement_client import ask_engagement
from common.link.request_client import RequestClient
from common.messages.requests import EngagementAction
from common.messages.robot import STOPPED, SessionState
from lab.stage.network.command_socket import send
from tests.faults.acts import hand
from tests.faults.cell_pair import CellPair
from tests.faults.pair_setup import CELL
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


def stop_behind_reset(trial: Trial) -> None:
    """Stops of others come just before the operator's reset, and during a fault: it clears none that was not shown."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: pair.ask(EngagementAction.STOP))
    trial.rests(stop_within_s=0.1)
    pair.wait("the stop", lambda: pair.state.code == STOPPED)
    _reset_misses_a_stop(trial)
    trial.check(pair.ask(EngagementAction.RESET).done, "a reset by who was shown the stop was refused")
    pair.robot(fault="robot")
    pair.wait("the fault", lambda: pair.is_in(SessionState.FAULT), 10)
    pair.robot(fault="")
    _reset_misses_a_stop(trial)
    trial.stays(2.0)
    pair.engage()


def _reset_misses_a_stop(trial: Trial) -> None:
    """Maintenance stops the arm after the operator has looked: the operator's reset and engagement are refused."""
    pair, shown_ns = trial.pair, trial.pair.state.halted_ns
    with pair.maintenance() as link:
        ask_engagement(RequestClient(link, CELL), EngagementAction.STOP, maintenance=True)
    reset = pair.ask(EngagementAction.RESET, shown_ns)
    trial.check(not reset.done and "stopped by maintenance" in reset.reason, f"the reset was answered: {reset.reason}")
    trial.check(not pair.ask(EngagementAction.ENGAGE).done, "it engaged without a reset")
    trial.check("stopped by maintenance" in pair.state.reason, f"the state hides who stopped it: {pair.state.reason}")
    shown = pair.state.reason.removesuffix("; reset it, then engage")
    trial.check(any(shown in line for line in pair.remote.lines), f"no line of the log says: {shown}")


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

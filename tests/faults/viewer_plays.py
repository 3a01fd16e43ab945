"""A crowd of viewers at their endpoint, and the end of the process that serves them: neither is the arm's concern."""

import os
import signal
import time
from contextlib import ExitStack

from common.link.channels import STATE
from common.link.engagement_client import ask_engagement
from common.link.request_client import RequestClient
from common.messages.requests import EngagementAction
from tests.faults.cell_pair import CellPair
from tests.faults.pair_setup import CELL
from tests.faults.trial import Trial
from tests.integration.sites import child_of

CROWD = 70  # more than a session has neighbours
WATCHED_S = 5.0


def watch_in_crowds(trial: Trial) -> None:
    """The arm follows while a crowd watches; a stop of maintenance that comes then is heard; no viewer is needed."""
    pair = trial.pair
    pair.move()
    with ExitStack() as stack:
        trial.begin(lambda pair: _crowd(pair, stack, trial))
        time.sleep(WATCHED_S)
        trial.follows(0.95)
        trial.begin(lambda pair: trial.check(_stop_by_maintenance(pair), "maintenance was refused"))
        trial.note(f"maintenance's stop was answered {trial.elapsed_s:.1f} s after it began to connect")
        trial.latches()
        trial.check(pair.ask(EngagementAction.STOP).done, "the operator's stop was refused")
        os.kill(child_of(pair.remote, "farhand-viewers"), signal.SIGKILL)
        pair.wait("the site to say so", lambda: any("process=viewers" in line for line in pair.remote.events), 5)
    trial.check(pair.ask(EngagementAction.RESET).done, "the operator's reset was refused")
    pair.engage()
    trial.ticks()


def _crowd(pair: CellPair, stack: ExitStack, trial: Trial) -> None:
    """Connect all viewers, and have each listen to the state."""
    listening = [stack.enter_context(pair.viewer()).latest(STATE, CELL) for _ in range(CROWD)]
    time.sleep(1.0)
    seeing = sum(latest.take() is not None for latest in listening)
    trial.note(f"{seeing} of {CROWD} viewers see the state")
    trial.check(seeing > CROWD // 2, f"only {seeing} viewers see anything")


def _stop_by_maintenance(pair: CellPair) -> bool:
    """A new session's stop."""
    with pair.maintenance() as link:
        return ask_engagement(RequestClient(link, CELL), EngagementAction.STOP, maintenance=True).done

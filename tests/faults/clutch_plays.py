"""The clutch in full motion: its page falls silent, or it is let go while the hand still moves; the arm stays."""

import os
import signal

from common.messages.hand import ClutchKey
from common.messages.requests import EngagementAction
from farhand.loopback.site_process import SiteProcess
from lab.stage.network.command_socket import send
from tests.faults.trial import Trial

STOP_S = 0.25  # a beat, an intent and a sample after the press the arm begins to stop
PATIENCE_S = 5.0


def silent_clutch(trial: Trial) -> None:
    """The page falls silent under the clutch and reports it up afterwards: held, and disengaged until it is let go."""
    pair, page = trial.pair, _clutches(trial)
    os.kill(page.pid, signal.SIGSTOP)
    pair.wait("the silence", lambda: pair.state.code == "page_silent", PATIENCE_S)
    send(pair.folder / "page", clutch=ClutchKey.UP)
    os.kill(page.pid, signal.SIGCONT)
    pair.wait("the page", lambda: pair.state.code == "clutch_unseen", PATIENCE_S)
    trial.latches(pair.config.safety.longest_hold_ms / 1e3)
    trial.stays()
    answer = pair.ask(EngagementAction.ENGAGE)
    trial.check(not answer.done and answer.code == "clutch_unseen", f"an engagement was answered: {answer.reason}")
    send(pair.folder / "page", clutch=ClutchKey.DOWN)
    pair.wait("the press", lambda: pair.state.readiness.code == "clutched", PATIENCE_S)
    send(pair.folder / "page", clutch=ClutchKey.UP)
    pair.follow_from_here()
    pair.end_console()


def restless_release(trial: Trial) -> None:
    """The clutch is let go while the hand goes on circling: the arm stays, and is disengaged."""
    pair = trial.pair
    _clutches(trial)
    send(pair.folder / "page", clutch=ClutchKey.UP)
    pair.wait("the release", lambda: pair.state.code == "clutch_settling", PATIENCE_S)
    trial.latches(pair.config.safety.longest_hold_ms / 1e3)
    trial.stays()
    pair.end_console()


def _clutches(trial: Trial) -> SiteProcess:
    """Press the clutch of a new page while the arm moves: it comes to rest; the page."""
    pair = trial.pair
    page = pair.start_page(pair.start_console())
    pair.follow_from_here()
    pair.move()
    trial.begin(lambda pair: send(pair.folder / "page", clutch=ClutchKey.DOWN))
    trial.rests(stop_within_s=STOP_S)
    trial.check(pair.state.code == "clutched", f"the reason is {pair.state.code}")
    return page

"""Processes that pause or die while the arm moves: control, the driver's, the remote site, the page or its console."""

import os
import signal
import time

import numpy as np

from common.messages.robot import SessionState
from lab.stage.network.command_socket import send
from tests.faults.cell_pair import CellPair
from tests.faults.driver_log import ROUNDING
from tests.faults.plays import Play
from tests.faults.recorded_arm import RecordedArm
from tests.faults.trial import Trial
from tests.integration.sites import child_of

WATCHDOG_MS = 200.0  # of the A465's controller
SILENT_S = 0.4  # until a console that is gone counts as silent: 200 ms, a sample, its path
LATE_S = 3.0
PAUSES, BETWEEN_S = 6, 0.9
LOCKED_MM = 5.0  # of z, whose hand sweeps 80: the joints lag differently while the arm moves fast
FOLLOWED_MM = 20.0


def kill_control(trial: Trial) -> None:
    """Control is killed: the driver's process stops the arm, and what starts again is not engaged."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.kill(child_of(pair.remote, "farhand-control"), signal.SIGKILL))
    trial.rests()
    pair.wait("the remote site to end", lambda: pair.remote.exit_code is not None, 10)
    trial.check("control" in "".join(pair.remote.lines), "the site does not name the dead process")
    start_again(trial)


def kill_remote(trial: Trial) -> None:
    """All processes of the remote site are killed: the robot's own watchdog stops it."""
    pair = trial.pair
    pair.move()
    trial.begin(lambda pair: os.killpg(pair.remote.pid, signal.SIGKILL))
    trial.rests(stop_within_s=WATCHDOG_MS / 1e3)
    start_again(trial)


def pause_driver(pauses_s: float) -> Play:
    """A position arm's driver pauses again and again: no step is longer than a period's motion at full speed."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.move()
        trial.begin(lambda _: None)
        for _ in range(PAUSES):
            driver = child_of(pair.remote, "farhand-driver")
            os.kill(driver, signal.SIGSTOP)
            time.sleep(pauses_s)
            os.kill(driver, signal.SIGCONT)
            time.sleep(BETWEEN_S)
        steps = np.abs(np.diff(trial.log.q, axis=0)) * RecordedArm.rate_hz / pair.limits.velocity
        trial.note(f"the longest step was {steps.max():.2f} of a period's at full speed")
        trial.check(steps.max() <= ROUNDING, f"a step was {steps.max():.2f} of a period's at full speed")
        trial.check(pair.is_in(SessionState.ENGAGED), f"it does not follow: {pair.state.reason}")
        trial.obeys_nothing_old()

    return play


def start_again(trial: Trial) -> None:
    """Start the remote site again, with a good hand in view: nothing engages."""
    trial.pair.start_remote()
    trial.pair.wait("a good hand", lambda: trial.pair.state.readiness.ready)
    trial.stays()


def close_page(trial: Trial) -> None:
    """The page whose key is held is killed: the arm stops, and a new page with the key down moves nothing."""
    pair, port = trial.pair, trial.pair.start_console()
    page = pair.start_page(port)
    pair.wait("readiness", lambda: pair.state.readiness.ready)
    pair.wait("the key to count as released", lambda: press_until_engaged(pair))
    pair.move()
    trial.begin(lambda _: os.kill(page.pid, signal.SIGKILL))
    trial.latches(0.5)
    trial.rests(stop_within_s=0.5)
    pair.start_page(port, down=True)
    trial.stays(2.0)


def late_page(trial: Trial) -> None:
    """All that the page reports comes 3 s late: its key moves nothing, until it is pressed anew without the delay."""
    pair, port = trial.pair, trial.pair.start_console()
    pair.start_page(port)
    send(pair.folder / "page", late_s=LATE_S)
    pair.wait("readiness", lambda: pair.state.readiness.ready)
    time.sleep(2 * LATE_S)
    trial.begin(lambda pair: send(pair.folder / "page", down=True))
    trial.rested_ns = trial.fault_ns
    trial.stays(2 * LATE_S)
    send(pair.folder / "page", late_s=0.0)
    trial.stays()
    pair.wait("an engagement by a new press", lambda: press_until_engaged(pair), 10)


def press_until_engaged(pair: CellPair) -> bool:
    """Release the page's key for a while, press it, and report whether the arm follows."""
    for down in (False, True):
        send(pair.folder / "page", down=down)
        time.sleep(0.7)
    return pair.is_in(SessionState.ENGAGED)


def kill_console(trial: Trial) -> None:
    """The console is killed while z is locked: the arm holds, and z stays locked when a new one brings a new page."""
    pair = trial.pair
    pair.start_page(pair.start_console())
    pair.wait("the lock", lambda: _locks_z(pair))
    locked_ns = time.monotonic_ns()
    pair.move()
    trial.begin(lambda pair: os.kill(pair.console.pid, signal.SIGKILL))
    trial.rests(stop_within_s=SILENT_S)
    trial.note(f"{pair.state.state.value}: {pair.state.reason}")
    trial.check(pair.is_in(SessionState.HOLDING), "it does not hold")
    trial.check(pair.state.code == "page_silent", f"the reason is {pair.state.code}")

    pair.start_page(pair.start_console())
    pair.follow_from_here()
    pair.move()
    settings = pair.state.settings
    trial.check(settings is not None and settings.locks.z, "the remote site has forgotten the lock")
    moved_mm = 1e3 * np.ptp(pair.log(locked_ns).positions, axis=0)
    trial.note(f"commanded range in x, y and z: {', '.join(f'{mm:.2f}' for mm in moved_mm)} mm")
    trial.check(moved_mm[2] < LOCKED_MM, f"the locked z was moved by {moved_mm[2]:.1f} mm")
    trial.check(moved_mm[:2].max() > FOLLOWED_MM, "the arm did not follow at all")
    pair.end_console()


def _locks_z(pair: CellPair) -> bool:
    """Have the page lock z, and report whether the remote site has done so."""
    send(pair.folder / "page", steer={"locks": {"z": True}})
    time.sleep(0.1)
    return pair.state.settings is not None and pair.state.settings.locks.z

"""What may not move the gripper: a new start while it holds, counts that no hand makes, orders that it missed."""

import os
import signal
import time

from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, SessionState
from tests.faults.acts import Act
from tests.faults.cell_pair import CellPair
from tests.faults.emulated_robot import OBJECT_M
from tests.faults.plays import Play, unmoved
from tests.faults.trial import Trial

OPENS_M = 0.002
GRIP_S = 1.5
PATIENCE_S = 60.0


def restart_while_holding(trial: Trial) -> None:
    """The site is killed, then ended in order; started again and engaged, it leaves the gripper as it was."""
    pair = trial.pair
    while not is_held(pair):
        toggle(pair)
    trial.begin(lambda pair: os.killpg(pair.remote.pid, signal.SIGKILL))
    for _ in range(2):
        pair.start_remote()
        pair.wait("a good hand", lambda: pair.state.readiness.ready)
        pair.engage()
        time.sleep(GRIP_S)
    seen = [state.gripper for state in pair.states if state.t_ns > trial.fault_ns and state.gripper is not None]
    widest_m = max(gripper.opening for gripper in seen)
    trial.note(f"held, {1e3 * widest_m:.1f} mm wide at most in {len(seen)} states")
    trial.check(widest_m < OBJECT_M + OPENS_M, f"the gripper opened to {1e3 * widest_m:.1f} mm")
    commanded = {gripper.commanded for gripper in seen}
    trial.check(commanded == {GripperCommand.KEEP}, f"the gripper was commanded: {sorted(commanded)}")
    trial.check(pair.state.gripper_next is GripperCommand.CLOSED, "of an unknown grip the first toggle opens")
    toggle(pair)
    trial.check(is_held(pair), "the first toggle has opened the gripper")
    toggle(pair)
    trial.check(not is_held(pair), "the second toggle has not opened the gripper")


def miss_an_order(trial: Trial) -> None:
    """Told to open while its link is down; when that is back, after stop, reset and engagement, the gripper holds."""
    pair = trial.pair
    pair.wait("a measured gripper", lambda: is_held(pair))
    while pair.state.gripper_next is not GripperCommand.OPEN:
        toggle(pair)
    trial.begin(lambda pair: pair.robot(gripper_lost=True))
    pair.wait("the loss of the gripper", lambda: pair.state.gripper is None)
    order(pair)
    for action in (EngagementAction.STOP, EngagementAction.RESET):
        trial.check(pair.ask(action).done, f"no {action.value}")
    pair.follow_from_here()
    pair.robot(gripper_lost=False)
    pair.wait("the gripper", lambda: pair.state.gripper is not None)
    time.sleep(GRIP_S)
    seen = [state.gripper for state in pair.states if state.t_ns > trial.fault_ns and state.gripper is not None]
    widest_m = max(gripper.opening for gripper in seen)
    trial.note(f"held, {1e3 * widest_m:.1f} mm wide at most")
    trial.check(widest_m < OBJECT_M + OPENS_M, f"the gripper opened to {1e3 * widest_m:.1f} mm")
    trial.check(pair.is_in(SessionState.ENGAGED), f"it does not follow: {pair.state.reason}")
    while is_held(pair) and trial.elapsed_s < PATIENCE_S:
        toggle(pair)
    trial.check(not is_held(pair), "no toggle opens the gripper any more")


def uncounted(act: Act) -> Play:
    """Openings that no hand makes: neither the gripper nor the arm moves, and control goes on."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        applied = pair.state.gripper_toggles_applied
        unmoved(act)(trial)
        states = [state for state in pair.states if state.t_ns > trial.fault_ns]
        counted = max(state.gripper_toggles_applied for state in states) - applied
        trial.note(f"{counted} openings counted in {len(states)} states")
        trial.check(not counted, f"{counted} openings were applied")
        trial.check(pair.is_in(SessionState.ENGAGED), f"it does not follow: {pair.state.reason}")

    return play


def is_held(pair: CellPair) -> bool:
    """The gripper is as narrow as the object."""
    gripper = pair.state.gripper
    return gripper is not None and gripper.opening < OBJECT_M + OPENS_M


def toggle(pair: CellPair) -> None:
    """Open the hand and close it, and wait until the gripper has done what it should."""
    order(pair)
    time.sleep(GRIP_S)


def order(pair: CellPair) -> None:
    """Open the hand and close it."""
    applied = pair.state.gripper_toggles_applied
    pair.hand(open=True)
    pair.wait("the toggle", lambda: pair.state.gripper_toggles_applied > applied, 5)
    pair.hand(open=False)

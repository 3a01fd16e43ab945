"""How most faults are played: the arm stops and latches, holds, continues, or does not move, and the checks of each."""

import time
from collections.abc import Callable

import numpy as np

from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from tests.faults.acts import Act, jumps
from tests.faults.forgery import ask_for_lease
from tests.faults.trial import FOLLOWING, Trial

Play = Callable[[Trial], None]

STILL_MM = 1.0


def latch(fault: Act, heal: Act, *, says: str = "", for_s: float = 0.0) -> Play:
    """A moving arm stops and latches, and stays where it is when the fault is over, however long it was."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        trial.latches()
        trial.rests()
        trial.check(says in trial.pair.state.reason, f"the reason does not say {says!r}: {trial.pair.state.reason}")
        time.sleep(max(for_s - trial.elapsed_s, 0.0))
        heal(trial.pair)
        trial.stays()

    return play


def hold(fault: Act, heal: Act, for_s: float) -> Play:
    """A moving arm stops for as long as the fault lasts."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        trial.rests()
        time.sleep(for_s)
        trial.check(not trial.log.moves_after(trial.rested_ns), "it moved during the fault")
        trial.note(f"{trial.pair.state.state.value}: {trial.pair.state.reason}")
        heal(trial.pair)

    return play


def blink(fault: Act, heal: Act, for_s: float) -> Play:
    """A fault too short to latch: the arm continues, or stops and continues, and never obeys what is too old."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        time.sleep(for_s)
        heal(trial.pair)
        time.sleep(1.5)
        trial.check(trial.pair.is_in(SessionState.ENGAGED), f"it does not follow: {trial.pair.state.reason}")
        trial.obeys_nothing_old()

    return play


def outlast(fault: Act, least_fraction: float) -> Play:
    """The arm follows while the fault lasts."""

    def play(trial: Trial) -> None:
        trial.pair.move()
        trial.begin(fault)
        trial.follows(least_fraction)
        trial.obeys_nothing_old()

    return play


def unmoved(fault: Act, *counted: str) -> Play:
    """An arm that follows a hand at rest does not move, and each of these refusals was counted."""

    def play(trial: Trial) -> None:
        time.sleep(0.7)
        before = dict(trial.pair.state.rejected)
        trial.begin(fault)
        time.sleep(0.3)
        state = trial.pair.state
        risen = {code: count - before.get(code, 0) for code, count in state.rejected.items()}
        trial.note(", ".join(f"{code} {count}" for code, count in risen.items() if count))
        for code in counted:
            trial.check(risen.get(code), f"{code} was not counted")
        tool = trial.log.positions
        moved_mm = 1e3 * float(np.linalg.norm(tool - tool[0], axis=1).max(initial=0.0)) if len(tool) else 0.0
        trial.note(f"commanded motion {moved_mm:.2f} mm")
        trial.check(moved_mm < STILL_MM, f"the tool was sent {moved_mm:.1f} mm away")
        trial.ticks()

    return play


def jump_then_three(trial: Trial) -> None:
    """One jump is refused; three in a row latch; the arm is not moved by any."""
    unmoved(jumps(1), "jump")(trial)
    trial.check(trial.pair.state.state in FOLLOWING, "one jump ended the engagement")
    unmoved(jumps(3), "jumps")(trial)
    trial.latches()


def second_operator(act: Act) -> Play:
    """Another operator is refused with the holder's name, and its samples are fenced."""

    def play(trial: Trial) -> None:
        answer = ask_for_lease(trial.pair, "ben")
        trial.note(f"{answer.code}: {answer.reason}")
        trial.check(not answer.done and "anna" in answer.reason, "the other was not refused with the holder's name")
        unmoved(act, "not_holder", "old_lease")(trial)
        trial.check(trial.pair.is_in(SessionState.ENGAGED), "the holder lost the arm")

    return play


def faulty(fault: Act, repair: Act, *, says: str, more_s: float = 0.0, silent: bool = False) -> Play:
    """The robot or its driver fails: the arm stops, the fault is reported, and only a request clears it."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.move()
        trial.begin(fault)
        trial.latches()
        trial.rests(more_s=more_s)
        trial.check(pair.is_in(SessionState.FAULT), f"no fault but {pair.state.state.value}")
        trial.check(says in pair.state.reason, f"the reason does not say {says!r}: {pair.state.reason}")
        if silent:
            trial.obeys_no_command()
            trial.check(not pair.ask(EngagementAction.ENGAGE).done, "it engaged with the fault still there")
        repair(pair)
        trial.stays()
        trial.check(pair.is_in(SessionState.FAULT) or silent, "the fault cleared itself")
        trial.ticks()

    return play

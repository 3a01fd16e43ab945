"""How most faults are played: the arm stops and latches, holds, continues, or does not move, and the checks of each."""

import time
from collections.abc import Callable

import numpy as np

from common.messages.requests import EngagementAction
from common.messages.robot import FOLLOWING, SessionState
from tests.faults.acts import Act, jumps, robot
from tests.faults.cell_pair import CellPair
from tests.faults.forgery import ask_for_lease, consent
from tests.faults.pair_setup import OPERATOR, OTHERS
from tests.faults.trial import Trial

Play = Callable[[Trial], None]

STILL_MM = 1.0
SURE_M = 0.002
SWING_DEG, BACK_DEG = 5.0, 1.0  # what a swap of two fingers may turn the tool, and leave turned
MAKES_UP_S = 3.0
ASKING_S = 8.0  # longer than who asked once is named
NOTICED_S = 1.5  # the arm has to be commanded 0.1 rad away, by a hand that circles


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


def by_palm(play: Play) -> Play:
    """The same while the tool copies the palm, which the scripted tracker shows only then."""

    def shown(trial: Trial) -> None:
        trial.pair.hand(palm_sigma_m=SURE_M)
        trial.pair.engage()
        play(trial)

    return shown


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
        trial.settle()
        risen = trial.provoke(fault, counted)
        trial.note(", ".join(f"{code} {count}" for code, count in risen.items()))
        for code in counted:
            trial.check(risen.get(code), f"{code} was not counted")
        tool = trial.log.positions
        moved_mm = 1e3 * float(np.linalg.norm(tool - tool[0], axis=1).max(initial=0.0)) if len(tool) else 0.0
        trial.note(f"commanded motion {moved_mm:.2f} mm")
        trial.check(moved_mm < STILL_MM, f"the tool was sent {moved_mm:.1f} mm away")
        trial.ticks()

    return play


def unswung(fault: Act, heal: Act, for_s: float) -> Play:
    """The tool that follows a hand at rest turns a little at most, and back afterwards."""

    def play(trial: Trial) -> None:
        trial.settle()
        trial.begin(fault)
        time.sleep(for_s)
        heal(trial.pair)
        time.sleep(MAKES_UP_S)
        turned = trial.log.turned_deg
        trial.note(f"turned by up to {turned.max():.1f} deg, {turned[-1]:.1f} in the end")
        trial.check(turned.max() < SWING_DEG, f"the tool swung by {turned.max():.1f} deg")
        trial.check(turned[-1] < BACK_DEG, f"the tool is still turned by {turned[-1]:.1f} deg")
        trial.check(trial.pair.is_in(SessionState.ENGAGED), f"it does not follow: {trial.pair.state.reason}")

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
        answer = ask_for_lease(trial.pair, OTHERS[0])
        trial.note(f"{answer.code}: {answer.reason}")
        trial.check(not answer.done and OPERATOR in answer.reason, "the other was not refused with the holder's name")
        unmoved(act, "not_holder", "old_lease")(trial)
        trial.check(trial.pair.is_in(SessionState.ENGAGED), "the holder lost the arm")

    return play


def usurped(act: Act) -> Play:
    """Another operator pretends to be the holder: the arm does not move, and stays the holder's."""

    def play(trial: Trial) -> None:
        unmoved(act, "not_holder")(trial)
        trial.check(trial.pair.is_in(SessionState.ENGAGED), f"it was disengaged: {trial.pair.state.reason}")
        lease = trial.pair.state.lease
        trial.check(lease is not None and lease.holder == OPERATOR, "the holder lost the lease")

    return play


def changed_asker(trial: Trial) -> None:
    """The holder consents to who was shown to ask for the lease, while by now somebody else does."""
    pair = trial.pair
    ask_for_lease(pair, OTHERS[0])
    pair.wait("the first to be shown", lambda: _asker(pair) == OTHERS[0], 2)
    lease = pair.state.lease
    shown = lease.asked_by if lease is not None else None
    pair.wait("the first to give up", lambda: _asker(pair) is None, ASKING_S)
    ask_for_lease(pair, OTHERS[1])
    trial.begin(lambda _: None)
    assert shown is not None, "nobody was shown to ask"
    answer = consent(pair, shown)
    trial.note(answer.reason)
    trial.check((answer.done, answer.code) == (False, "asker_changed"), "the consent was not void")
    trial.check(OTHERS[1] in answer.reason, "who asks now is not named")
    time.sleep(0.3)
    lease = pair.state.lease
    trial.check(lease is not None and lease.holder == OPERATOR, "the holder lost the lease")
    trial.check(pair.is_in(SessionState.ENGAGED), f"it was disengaged: {pair.state.reason}")


def _asker(pair: CellPair) -> str | None:
    lease = pair.state.lease
    return lease.asked_by.name if lease is not None and lease.asked_by is not None else None


def astray(trial: Trial) -> None:
    """An arm that is held while it is commanded on is stopped, with the joint's name, and stays until it is reset."""
    pair = trial.pair
    pair.move()
    trial.begin(robot(misreads="held"))
    trial.latches(NOTICED_S)
    trial.rests(stop_within_s=NOTICED_S)
    trial.check("not_following" in pair.state.reason, f"not as not following: {pair.state.reason}")
    trial.check(any(name in pair.state.reason for name in pair.model.joint_names), "no joint is named")
    robot(misreads="")(pair)
    trial.stays()
    trial.check(pair.is_in(SessionState.FAULT), "the fault cleared itself")
    trial.ticks()


def faulty(
    fault: Act, repair: Act, *, says: str, more_s: float = 0.0, silent: bool = False, within_s: float | None = None
) -> Play:
    """The robot or its driver fails: the arm stops, the fault is reported, and only a reset clears it."""

    def play(trial: Trial) -> None:
        pair = trial.pair
        pair.move()
        trial.begin(fault)
        trial.latches()
        trial.rests(more_s=more_s, stop_within_s=within_s)
        trial.check(pair.is_in(SessionState.FAULT), f"no fault but {pair.state.state.value}")
        trial.check(says in pair.state.reason, f"the reason does not say {says!r}: {pair.state.reason}")
        if silent:
            trial.obeys_no_command()
        repair(pair)
        trial.check(not pair.ask(EngagementAction.ENGAGE).done, "it engaged without a reset")
        trial.stays()
        trial.check(pair.is_in(SessionState.FAULT), "the fault cleared itself")
        trial.ticks()

    return play

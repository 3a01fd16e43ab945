"""An arm far away: over an ordinary Internet link it follows, over a worse one it states why not."""

import time
from itertools import pairwise
from typing import Any

from common.clock import NS_PER_S
from common.messages.requests import EngagementAction
from common.messages.robot import FOLLOWING, SessionState
from tests.faults.acts import impair
from tests.faults.plays import Play
from tests.faults.trial import Trial

LEARNS_S = 3.0  # of a link, before the engagement
FOLLOWS_AGAIN_S = 1.0  # after a cut of 300 ms
MOST_CHANGES = 2  # between engaged and holding in a second


def engage_over(trial: Trial, **impairment: Any) -> None:
    """Have the arm follow a circling hand over an impaired link."""
    trial.pair.impair(**impairment)
    time.sleep(LEARNS_S)
    trial.pair.engage()
    trial.pair.move()


def far(seconds: float, least_fraction: float, **impairment: Any) -> Play:
    """The arm follows over the link, without flicker, and obeys nothing too old."""

    def play(trial: Trial) -> None:
        engage_over(trial, **impairment)
        trial.begin(lambda _: None)
        time.sleep(seconds)
        trial.follows(least_fraction)
        trial.obeys_nothing_old()
        changes = most_changes(trial)
        trial.note(f"samples up to {trial.pair.state.age_limit_ms:.0f} ms old; {changes} changes in the worst second")
        trial.check(changes <= MOST_CHANGES, f"it changed {changes} times in a second")

    return play


def over(play_there: Play, **impairment: Any) -> Play:
    """A fault on a far link."""

    def play(trial: Trial) -> None:
        trial.pair.impair(**impairment)
        time.sleep(LEARNS_S)
        trial.pair.engage()
        play_there(trial)

    return play


def cut_shortly(seconds: float, **impairment: Any) -> Play:
    """A short cut of a far link holds the arm, which then follows again within a second."""

    def play(trial: Trial) -> None:
        engage_over(trial, **impairment)
        trial.begin(impair(cut=True))
        time.sleep(seconds)
        trial.pair.impair(**impairment)
        healed_ns = time.monotonic_ns()
        trial.pair.wait("the arm to follow", lambda: _follows_since(trial, healed_ns), 5)
        took_s = (trial.pair.state.t_ns - healed_ns) / NS_PER_S
        trial.note(f"followed {1e3 * took_s:.0f} ms after the cut")
        trial.check(took_s <= FOLLOWS_AGAIN_S, f"it followed only after {took_s:.1f} s")
        trial.obeys_nothing_old()

    return play


def jump_of_delay(delays_ms: tuple[float, float], seconds: float) -> Play:
    """A delay that jumps costs one hold at most; the arm follows again within 2 s."""

    def play(trial: Trial) -> None:
        engage_over(trial, delay_ms=delays_ms[0])
        trial.begin(impair(delay_ms=delays_ms[1]))
        time.sleep(seconds)
        trial.follows(1.0 - 2.0 / seconds)
        trial.obeys_nothing_old()
        trial.check(holds(trial) <= 1, f"it held {holds(trial)} times")

    return play


def too_far(trial: Trial) -> None:
    """Over a link that takes too long nothing engages, and the reason states both figures."""
    trial.pair.impair(delay_ms=190)
    trial.begin(lambda _: None)
    trial.pair.wait("the refusal", lambda: trial.pair.state.readiness.code == "link_too_slow", 20)
    trial.note(trial.pair.state.readiness.reason)
    answer = trial.pair.ask(EngagementAction.ENGAGE)
    trial.check(not answer.done and "can be operated" in answer.reason, f"it engaged: {answer.reason}")
    trial.check(not trial.log.moves_after(trial.fault_ns), "it moved")
    trial.pair.impair()


def most_changes(trial: Trial) -> int:
    """The greatest number of changes between engaged and holding within a second."""
    times = _changes(trial)
    return max((sum(t <= other < t + NS_PER_S for other in times) for t in times), default=0)


def holds(trial: Trial) -> int:
    """How often the arm held since the fault."""
    states = [state for state in trial.pair.states if state.t_ns > trial.fault_ns]
    begun = pairwise(states)
    return sum(one.state is SessionState.ENGAGED and other.state is SessionState.HOLDING for one, other in begun)


def _changes(trial: Trial) -> list[int]:
    states = [state for state in trial.pair.states if state.t_ns > trial.fault_ns and state.state in FOLLOWING]
    pairs = pairwise(states)
    return [other.t_ns for one, other in pairs if one.state is not other.state]


def _follows_since(trial: Trial, t_ns: int) -> bool:
    state = trial.pair.state
    fresh = state.obeyed is not None and state.obeyed.capture_ns > trial.fault_ns
    return fresh and state.t_ns > t_ns and state.state is SessionState.ENGAGED

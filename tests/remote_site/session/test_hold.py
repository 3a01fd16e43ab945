"""Holds within an engagement: one after another lasts longer, and only those that age caused keep the origins."""

import pytest

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.reasons import Code, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.hold import APART_NS, Hold
from remote_site.session.samples import Rejected
from remote_site.session.state_machine import Action, Decision
from tests.remote_site.session.session_rig import LOST, NO_OFFSET, PERIOD, READY, SessionRig, engaged, good

STALE = Rejected(reason(Code.STALE, age_ms=130, limit_ms=100))
JUMP = Rejected(reason(Code.JUMP, point="wrist", distance_mm=900, interval_ms=33))
UNCERTAIN = Rejected(reason(Code.UNCERTAIN, point="wrist", sigma_mm=50, limit_mm=40), hand_lost=True)


def silent(rig: SessionRig, milliseconds: int) -> Decision:
    """Ticks without samples."""
    for _ in range(milliseconds // 4):
        decision = rig.wait(4)
    return decision


def held(rig: SessionRig) -> SessionRig:
    """Let the samples cease until the arm holds."""
    assert silent(rig, 104).state is SessionState.HOLDING
    return rig


def until_it_follows(rig: SessionRig, most: int = 60) -> tuple[int, Decision]:
    """Good samples until the arm follows: how many, and the decision."""
    for count in range(1, most + 1):
        decision = rig.frames(1)
        if decision.state is SessionState.ENGAGED:
            return count, decision
    raise AssertionError("the arm never followed")


def test_after_a_short_hold_of_late_samples_alone_the_arm_goes_on() -> None:
    count, decision = until_it_follows(held(engaged()))
    assert (count, decision.action) == (3, Action.RESUME)


def test_the_decision_names_when_the_hold_began() -> None:
    rig = held(engaged())
    began_ns = rig.now_ns
    assert until_it_follows(rig)[1].held_since_ns == began_ns


def test_after_more_than_300_ms_new_origins_are_due() -> None:
    rig = held(engaged())
    silent(rig, 220)
    assert until_it_follows(rig)[1].action is Action.CAPTURE


def test_late_and_doubled_samples_during_the_hold_do_not_matter() -> None:
    rig = held(engaged())
    rig.session.sample(STALE)
    rig.session.sample(Rejected(reason(Code.DUPLICATE, seq=3)))
    assert until_it_follows(rig)[1].action is Action.RESUME


@pytest.mark.parametrize("what", [LOST, NO_OFFSET, JUMP, UNCERTAIN], ids=lambda what: str(what.reason.code))
def test_anything_else_during_the_hold_makes_new_origins_due(what: Rejected) -> None:
    rig = held(engaged())
    rig.session.sample(what)
    assert until_it_follows(rig)[1].action is Action.CAPTURE


def test_a_pause_of_control_makes_new_origins_due() -> None:
    rig = engaged()
    rig.frames(1)
    rig.now_ns += 104 * NS_PER_MS
    rig.session.sample(good(rig.now_ns))
    assert rig.session.tick(rig.now_ns, READY).reason.code is Code.PAUSED
    assert until_it_follows(rig)[1].action is Action.CAPTURE


def test_samples_that_piled_up_while_control_stood_still_do_not_end_a_hold() -> None:
    rig = held(engaged())
    for _ in range(4):
        rig.now_ns += PERIOD
        rig.session.sample(good(rig.now_ns))
    assert rig.session.tick(rig.now_ns, READY).reason.code is Code.PAUSED
    assert rig.frames(2).reason.code is Code.COLLECTING
    assert rig.frames(1).action is Action.CAPTURE


@pytest.mark.parametrize("before_ms", [0.0, 100.0])
def test_a_stop_of_the_drivers_own_in_or_just_before_the_hold_makes_new_origins_due(before_ms: float) -> None:
    rig = engaged()
    diverted = READY._replace(diverted=True)
    if before_ms:
        rig.frames(1, diverted)
        held(rig)
    else:
        held(rig)
        rig.session.tick(rig.now_ns, diverted)
    assert until_it_follows(rig)[1].action is Action.CAPTURE


def test_a_hold_soon_after_another_lasts_a_second_at_least() -> None:
    rig = held(engaged())
    assert until_it_follows(rig)[0] == 3
    held(rig)
    assert rig.frames(5).reason.code is Code.UNSTEADY
    count, decision = until_it_follows(rig)
    assert 5 + count == pytest.approx(1000 / 33, abs=1.5)
    assert decision.action is Action.CAPTURE


@pytest.mark.parametrize(("apart_ns", "code"), [(APART_NS - 1, Code.UNSTEADY), (APART_NS, None)])
def test_a_hold_earns_its_end_where_it_begins_within_five_seconds_of_another(apart_ns: int, code: Code | None) -> None:
    hold = Hold(SafetyConfig())
    hold.begin(0, reason(Code.MOVING))
    hold.begin(apart_ns, reason(Code.MOVING))
    why = hold.unearned(apart_ns + 250 * NS_PER_MS)
    assert (why.code if why is not None else None) is code
    assert why is None or "250 of 1000 ms" in why.sentence


def test_samples_that_came_before_the_hold_do_not_end_it() -> None:
    rig = engaged()
    assert silent(rig, 104).state is SessionState.HOLDING
    rig.session.sample(good(rig.now_ns - 40 * NS_PER_MS))  # by their births there is no gap in the row
    assert rig.session.tick(rig.now_ns, READY).reason.code is Code.COLLECTING
    assert rig.frames(1).action is Action.STOP
    assert rig.frames(1).action is Action.RESUME


def test_a_hold_long_after_another_ends_at_once() -> None:
    rig = held(engaged())
    until_it_follows(rig)
    rig.frames(160)
    assert until_it_follows(held(rig))[0] == 3


def test_whatever_the_link_does_the_state_changes_at_most_twice_a_second_once_it_has_begun_to_flicker() -> None:
    rig, changes, state = engaged(), [], SessionState.ENGAGED
    for k in range(3000):
        decision = silent(rig, 104) if k % 5 == 4 else rig.frames(1)
        if decision.state is not state:
            state = decision.state
            changes.append(rig.now_ns)
        if state is SessionState.DISENGAGED:
            break
    within_s = [sum(t <= other < t + 10**9 for other in changes) for t in changes]
    assert max(within_s[3:], default=0) <= 2

"""The clutch in the session: the arm waits while it is held, and goes on after a release that was seen, and calm."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.geometry import rotation_from_vector
from common.messages.hand import ClutchKey, Intent
from common.messages.robot import SessionState
from remote_site.reasons import Code, reason
from remote_site.safety.config import SafetyConfig
from remote_site.session.config import EngagementMode
from remote_site.session.samples import Accepted, Rejected
from remote_site.session.state_machine import Action, Decision
from tests.remote_site.remote_loop import hand
from tests.remote_site.session.session_rig import DEAD, JUMPS, OTHERS, PERIOD, READY, SessionRig, engaged, held

UP, DOWN, UNSEEN = ClutchKey.UP, ClutchKey.DOWN, ClutchKey.UNSEEN
LONGEST_MS = SafetyConfig().longest_hold_ms
CALM_FRAMES = 8  # in 200 ms: the first from which it counts, and seven later ones


def shown(
    rig: SessionRig,
    key: ClutchKey | None,
    *,
    held: bool = False,
    x_m: float = 0.0,
    turned_rad: float | None = None,
    **fields: Any,
) -> Accepted:
    """A good sample of now with the clutch like this; None where no page reports."""
    intent = None if key is None else Intent(hold=held, clutch=key)
    rotation = rotation_from_vector(np.array([turned_rad, 0.0, 0.0])) if turned_rad is not None else None
    sample = hand(1, rig.now_ns, intent=intent, **fields)
    return Accepted(sample, np.array([x_m, 0.0, 0.0]), rotation, rig.now_ns, new_session=False)


def see(rig: SessionRig, key: ClutchKey | None, count: int = 1, **fields: Any) -> Decision:
    """So many samples like this at the camera's rate, each followed by a tick; the last decision."""
    for _ in range(count):
        rig.now_ns += PERIOD
        rig.session.sample(shown(rig, key, **fields))
        decision = rig.session.tick(rig.now_ns, READY)
    return decision


def clutched(**engagement: Any) -> SessionRig:
    """Engaged, with the clutch held for a while."""
    rig = engaged(**engagement)
    assert see(rig, DOWN, 10).reason.code is Code.CLUTCHED
    return rig


def until_it_follows(rig: SessionRig, most: int = 40, **fields: Any) -> int:
    """Samples with the clutch up until the arm follows, from new origins."""
    for count in range(1, most + 1):
        decision = see(rig, UP, **fields)
        if decision.state is SessionState.ENGAGED:
            assert decision.action is Action.CAPTURE
            return count
    raise AssertionError(f"the arm never followed: {decision}")


def test_the_arm_holds_from_the_first_sample_with_the_clutch_down_for_as_long_as_it_is_held() -> None:
    rig = engaged()
    decision = see(rig, DOWN)
    assert (decision.state, decision.action, decision.reason.code) == (
        SessionState.HOLDING,
        Action.STOP,
        Code.CLUTCHED,
    )
    decision = see(rig, DOWN, round(20 * LONGEST_MS / 33))
    assert (decision.state, decision.reason.code) == (SessionState.HOLDING, Code.CLUTCHED)


def test_after_the_release_it_follows_from_new_origins_once_the_hand_was_calm_for_200_ms() -> None:
    rig = clutched()
    assert see(rig, UP, CALM_FRAMES - 1).reason.code is Code.CLUTCH_SETTLING
    assert until_it_follows(rig) == 1


def test_a_hand_that_was_calm_before_the_release_has_to_be_calm_after_it() -> None:
    rig = clutched()
    see(rig, DOWN, 30)
    assert until_it_follows(rig) == CALM_FRAMES


def test_what_a_sample_shows_of_the_hand_before_it_was_sent_is_no_calm_after_the_release() -> None:
    rig = clutched()
    see(rig, UP, sent_ns=rig.now_ns + 3 * PERIOD)
    assert until_it_follows(rig) == 2 + CALM_FRAMES - 1


RESTLESS: dict[str, Callable[[int], dict[str, Any]]] = {
    "to and fro": lambda k: {"x_m": 0.016 * (k % 2)},
    "on and on": lambda k: {"x_m": 0.004 * k},
    "turning": lambda k: {"turned_rad": 0.05 * k},
    "turning too fast to be shown": lambda k: {"turned_rad": 0.0 if k % 2 else None},
    "opening and closing": lambda k: {"hand_open": k % 2 == 0},
}


@pytest.mark.parametrize("restless", RESTLESS.values(), ids=RESTLESS)
def test_a_hand_that_moves_is_not_followed_and_the_engagement_ends_after_the_longest_hold(
    restless: Callable[[int], dict[str, Any]],
) -> None:
    rig = clutched()
    states = [see(rig, UP, **restless(k)).state for k in range(round(LONGEST_MS / 33) + 2)]
    assert SessionState.ENGAGED not in states
    assert states[-1] is SessionState.DISENGAGED


def test_the_noise_of_a_calm_hand_is_no_motion() -> None:
    rig = clutched()
    for k in range(CALM_FRAMES):
        decision = see(rig, UP, x_m=0.007 * (k % 2), turned_rad=0.1 * (k % 2))
    assert decision.action is Action.CAPTURE


@pytest.mark.parametrize(
    "unseen",
    [
        lambda rig: rig.session.sample(Rejected(reason(Code.JUMP, point="wrist", distance_mm=99, interval_ms=33))),
        lambda rig: rig.wait(90),
    ],
    ids=["a jump", "a gap"],
)
def test_a_hand_that_is_not_seen_is_not_calm(unseen: Callable[[SessionRig], object]) -> None:
    rig = clutched()
    see(rig, UP, CALM_FRAMES - 2)
    unseen(rig)
    assert until_it_follows(rig) == CALM_FRAMES


def test_copies_and_late_samples_do_not_disturb_the_calm() -> None:
    rig = clutched()
    see(rig, UP, CALM_FRAMES - 1)
    rig.session.sample(Rejected(reason(Code.OLD, seq=1, newest=2)))
    assert until_it_follows(rig) == 1


def test_a_press_and_release_between_two_ticks_is_a_clutch_too() -> None:
    rig = engaged()
    rig.now_ns += PERIOD
    for key in (DOWN, UP):
        rig.session.sample(shown(rig, key))
    assert rig.session.tick(rig.now_ns, READY).reason.code is Code.CLUTCH_SETTLING
    assert until_it_follows(rig) == CALM_FRAMES - 1


def test_two_clutches_in_a_row_do_not_wait_longer() -> None:
    rig = clutched()
    until_it_follows(rig)
    see(rig, DOWN, 3)
    assert until_it_follows(rig) == CALM_FRAMES


def test_a_hold_after_a_clutch_is_the_first_of_its_kind_and_one_after_another_hold_is_not() -> None:
    rig = clutched()
    until_it_follows(rig)
    rig.wait(101)
    assert until_it_follows(rig) == 3
    see(rig, DOWN, 3)
    until_it_follows(rig)
    rig.wait(101)
    assert see(rig, UP, 10).reason.code is Code.UNSTEADY


SILENT: dict[str, Callable[[SessionRig], object]] = {
    "the page reports nothing": lambda rig: see(rig, None, 5),
    "the page lost the focus": lambda rig: see(rig, UNSEEN, 5),
    "a single sample without a report": lambda rig: see(rig, None),
}


@pytest.mark.parametrize("silence", SILENT.values(), ids=SILENT)
def test_a_release_that_nobody_reported_leaves_the_arm_held_and_then_disengaged(
    silence: Callable[[SessionRig], object],
) -> None:
    rig = clutched()
    began_ns = rig.now_ns
    silence(rig)
    decision = see(rig, UP)
    assert (decision.state, decision.reason.code) == (SessionState.HOLDING, Code.CLUTCH_UNSEEN)
    while decision.state is SessionState.HOLDING:
        decision = see(rig, UP)
    assert decision.state is SessionState.DISENGAGED
    assert decision.reason.code is Code.LATCHED
    assert LONGEST_MS <= (rig.now_ns - began_ns) / NS_PER_MS <= LONGEST_MS + 67


@pytest.mark.parametrize("silence", SILENT.values(), ids=SILENT)
def test_pressed_again_and_let_go_it_goes_on(silence: Callable[[SessionRig], object]) -> None:
    rig = clutched()
    silence(rig)
    see(rig, UP, 3)
    assert see(rig, DOWN).reason.code is Code.CLUTCHED
    assert until_it_follows(rig) == CALM_FRAMES


def test_a_hold_of_another_cause_counts_from_the_last_moment_at_which_the_clutch_was_held() -> None:
    rig = clutched()
    see(rig, DOWN, round(3 * LONGEST_MS / 33))
    assert see(rig, None, 5).state is SessionState.HOLDING


def test_a_link_that_is_lost_under_the_clutch_ends_the_engagement() -> None:
    rig = clutched()
    assert rig.wait(90).reason.code is Code.CLUTCHED
    assert rig.wait(90).reason.code is Code.STALE
    for _ in range(4):
        decision = rig.wait(90)
    assert (decision.state, decision.reason.code) == (SessionState.DISENGAGED, Code.LATCHED)


def test_a_release_counts_in_a_sample_whose_hand_is_lost_and_the_arm_waits_for_the_hand() -> None:
    rig = clutched()
    rig.now_ns += PERIOD
    rig.session.sample(Rejected(reason(Code.LOST, reason="gone"), hand_lost=True, sample=shown(rig, UP).sample))
    assert rig.session.tick(rig.now_ns, READY).reason.code is Code.LOST
    assert until_it_follows(rig) == CALM_FRAMES


@pytest.mark.parametrize("mode", [EngagementMode.HOLD_TO_RUN, EngagementMode.PEDAL])
def test_the_enabling_key_is_another_one_and_has_to_be_held_under_the_clutch(mode: EngagementMode) -> None:
    rig = held(mode)
    assert see(rig, DOWN, 10, held=True).reason.code is Code.CLUTCHED
    decision = see(rig, DOWN)
    assert (decision.state, decision.reason.code) == (SessionState.DISENGAGED, Code.LET_GO)
    assert see(rig, UP, 20).state is SessionState.DISENGAGED


@pytest.mark.parametrize("mode", [EngagementMode.HOLD_TO_RUN, EngagementMode.PEDAL])
def test_with_the_enabling_key_held_the_release_of_the_clutch_goes_on(mode: EngagementMode) -> None:
    rig = held(mode)
    see(rig, DOWN, 10, held=True)
    assert until_it_follows(rig, held=True) == CALM_FRAMES


@pytest.mark.parametrize("mode", [EngagementMode.HOLD_TO_RUN, EngagementMode.PEDAL])
def test_the_clutch_alone_engages_nothing_and_a_silent_page_lets_go_of_both(mode: EngagementMode) -> None:
    rig = SessionRig(mode=mode)
    see(rig, UP, 40)
    see(rig, DOWN, 10)
    assert see(rig, UP, 40).state is SessionState.DISENGAGED
    rig = held(mode)
    see(rig, DOWN, 3, held=True)
    assert see(rig, None).state is SessionState.DISENGAGED


@pytest.mark.parametrize(
    "end",
    [
        lambda rig: rig.session.request_disengage(rig.now_ns),
        lambda rig: rig.session.stop("ben", rig.now_ns),
        lambda rig: rig.session.fault("x", rig.now_ns),
        lambda rig: rig.session.sample(JUMPS),
        lambda rig: rig.session.authorise(OTHERS),
        lambda rig: rig.wait(4, DEAD),
    ],
    ids=["disengage", "stop", "fault", "jumps", "another lease", "robot"],
)
def test_what_ends_an_engagement_ends_it_under_the_clutch_and_the_release_begins_none(
    end: Callable[[SessionRig], object],
) -> None:
    rig = clutched()
    end(rig)
    assert see(rig, DOWN, 3).action is Action.STOP
    assert see(rig, UP, 60).action is Action.STOP


@pytest.mark.parametrize(("key", "code"), [(DOWN, Code.CLUTCHED), (UNSEEN, Code.CLUTCH_UNSEEN)])
def test_while_it_is_held_nothing_engages(key: ClutchKey, code: Code) -> None:
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    see(rig, key, 60)
    answer = rig.session.request_engage(rig.now_ns, READY)
    assert (answer.done, answer.reason.code) == (False, code)
    assert rig.session.readiness(rig.now_ns, READY).reason.code is code


def test_an_automatic_engagement_waits_for_its_release_and_a_calm_hand() -> None:
    rig = SessionRig()
    assert see(rig, DOWN, 60).state is SessionState.DISENGAGED
    assert until_it_follows(rig) == CALM_FRAMES


def test_a_new_lease_begins_with_the_clutch_up() -> None:
    rig = SessionRig(mode=EngagementMode.ON_REQUEST)
    see(rig, UNSEEN, 5)
    rig.session.authorise(OTHERS)
    see(rig, UP, 40)
    assert rig.session.request_engage(rig.now_ns, READY).done


def test_what_another_sends_neither_clutches_nor_lets_go() -> None:
    rig = clutched()
    stranger = Rejected(reason(Code.NOT_HOLDER, holder="anna"))
    rig.session.sample(stranger)
    assert see(rig, DOWN, 3).reason.code is Code.CLUTCHED


def test_a_late_sample_of_before_the_press_does_not_let_go_and_one_of_before_the_release_holds() -> None:
    rig = clutched()
    rig.session.sample(Rejected(reason(Code.OLD, seq=1, newest=2)))
    rig.session.sample(replace(Rejected(reason(Code.DUPLICATE, seq=2)), sample=None))
    assert see(rig, DOWN).reason.code is Code.CLUTCHED

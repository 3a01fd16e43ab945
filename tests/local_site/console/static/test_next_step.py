"""The next step, the bar and the line about the operator as somebody reads them who has never seen the page."""

from functools import partial

import pytest
from msgspec.structs import replace

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_S
from common.messages.robot import Asker, LeaseState, Pose, Readiness, SessionState
from lab.measure.page import scene
from local_site.console.model.seat import Visitor
from remote_site.session.fault_latch import EMERGENCY_STOP
from remote_site.session.halts import Halts
from tests.local_site.console.static.said import FOLLOWS, OPERATOR, READY, anothers, halted, said
from tests.present import present

ENDED = "the robot's driver has ended"
HERE, THERE = Visitor(1, "127.0.0.1"), Visitor(2, "10.0.0.7")


def stopped(*names: str, cause: str = "") -> str:
    """The remote site's own sentence."""
    halts = Halts()
    if cause:
        halts.fail(cause, 1)
    for name in names:
        halts.stop(name, 2)
    assert halts.reason is not None
    return halts.reason.sentence


def test_who_operates_is_said_once_and_rightly() -> None:
    assert said(FOLLOWS()).seat == "you operate (page 1)"
    watched = said(FOLLOWS(), page=2)
    assert watched.seat == "you watch; page 1 (127.0.0.1) operates"
    assert "leave the controls" in watched.step
    for other in (anothers(FOLLOWS()), anothers(READY())):
        shown = said(other)
        assert shown.word == "berta operates"
        assert shown.seat == ""
        assert shown.step == "To operate yourself, ask berta for the robot."
        assert said(other, page=2).seat == "you watch; page 1 (127.0.0.1) has the controls here"
    free = said(replace(READY(), lease=None))
    assert (free.seat, free.next) == ("", "lease-button")
    assert said(None).seat == "you operate (page 1)"


def test_who_has_asked_already_is_told_to_wait() -> None:
    state = anothers(READY())
    assert state.lease is not None
    asked = replace(state, lease=replace(state.lease, asked_by=Asker(OPERATOR, 7)))
    assert said(asked).step == "berta has been asked: wait until the robot is handed over."


@pytest.mark.parametrize(
    ("names", "stopper", "who"),
    [
        (("anna",), HERE, "you"),
        (("anna",), THERE, "another page, page 2 (10.0.0.7)"),
        (("anna",), None, "anna"),
        (("berta",), None, "berta"),
        (("anna", "berta"), HERE, "berta and you"),
        (("berta", EMERGENCY_STOP), None, "the robot's emergency stop and berta"),
    ],
)
def test_a_stop_says_who_it_was_and_that_reset_is_next(names: tuple[str, ...], stopper: Visitor, who: str) -> None:
    shown = said(halted(stopped(*names)), stopper=stopper)
    assert shown.sentence == f"stopped by {who}"
    assert shown.step.startswith("You stopped the arm." if who == "you" else f"Stopped by {who}.")
    assert ("whether it is safe to go on" in shown.step) == (who != "you")
    assert "press Reset" in shown.step
    assert shown.next == "reset"


@pytest.mark.parametrize("names", [(), ("berta",)])
def test_a_fault_says_its_cause_where_the_next_step_stands(names: tuple[str, ...]) -> None:
    shown = said(halted(stopped(*names, cause=ENDED), SessionState.FAULT, "fault"))
    assert f"Fault: {ENDED}." in shown.step
    assert "press Reset" in shown.step
    assert shown.sentence == " · ".join([*(f"stopped by {name}" for name in names), ENDED])
    assert ("Stopped by berta." in shown.step) == bool(names)


def test_an_exit_code_is_for_the_log() -> None:
    died = "the remote site ends by itself: remote: process driver died (exit code -9); start the site again"
    shown = said(halted(died, SessionState.FAULT, "site_failed"))
    assert shown.sentence == died.replace(" (exit code -9)", "")


@pytest.mark.parametrize("code", ["process", "not_following", "robot (E17)"])
def test_the_code_of_a_fault_is_for_the_log(code: str) -> None:
    shown = said(halted(stopped("berta", cause=f"{code}: {ENDED}"), SessionState.FAULT, "fault"))
    assert shown.sentence == f"stopped by berta · {ENDED}"
    assert said(halted(stopped(cause=f"{code}: {ENDED}"), SessionState.FAULT, "fault")).sentence == ENDED


def test_a_long_cause_leaves_room_for_what_to_do() -> None:
    shown = said(halted(stopped(cause="x" * 400), SessionState.FAULT, "fault"))
    assert len(shown.step) < 220
    assert shown.step.endswith("press Reset: that alone moves nothing.")


def test_what_a_fault_tells_people_to_do_is_said_whole_however_long_its_cause() -> None:
    cause = f"by its reading {'joint_3 and ' * 20}is huge; check the robot's sensors and the driver"
    shown = said(halted(stopped(cause=cause), SessionState.FAULT, "fault"))
    assert shown.step.startswith("Fault: by its reading joint_3")
    assert "… Ask somebody at the robot to check the robot's sensors and the driver, then press Reset:" in shown.step
    ended = said(halted(stopped(cause="joint_1 jumped; the arm has braked"), SessionState.FAULT, "fault"))
    assert "joint_1 jumped; the arm has braked. Ask somebody at the robot to put it right" in ended.step


@pytest.mark.parametrize(
    ("names", "asked"),
    [
        (("berta",), "berta"),
        (("berta", "carl"), "who stopped it"),
        ((EMERGENCY_STOP,), "who stopped it"),
        ((OPERATOR,), "who stopped it"),  # as by 'farhand stop' under the own name
    ],
)
def test_who_stopped_the_arm_is_asked_by_name_where_it_is_one_person(names: tuple[str, ...], asked: str) -> None:
    assert f"Ask {asked} whether it is safe to go on, then press Reset" in said(halted(stopped(*names))).step


def test_why_it_is_disengaged_is_said_once() -> None:
    disengaged = partial(replace, READY(), code="not_engaged", reason="not engaged yet")
    assert said(disengaged()).sentence == "ready"  # as the readiness is worded
    too_slow = "the link takes 431 ms, which is too slow: at most 345 ms can be operated"
    slow = Readiness(False, "link_too_slow", too_slow, False)
    late = "disengaged, newest hand sample is 507 ms old (limit 500 ms); engage again to continue"
    shown = said(disengaged(code="latched", reason=late, readiness=slow))
    assert shown.sentence == f"newest hand sample is 507 ms old (limit 500 ms) · {slow.reason}"
    assert shown.step == f"Not ready: {slow.reason}. Take a quicker way: a cable instead of Wi-Fi, no VPN."
    told = "hand samples are too old: 486 ms at arrival; the limit is 500 ms; network 421 ms. Cure: swim; or walk"
    link = replace(present(golden.STATE.hand_link), age_ms=486.0, code="samples_old", reason=told)
    linked = said(disengaged(code="latched", reason=late, readiness=slow, hand_link=link))
    assert linked.sentence == shown.sentence  # its age is said already
    assert linked.step == f"Not ready: {slow.reason}. To mend it, swim."
    held = said(replace(FOLLOWS(), state=SessionState.HOLDING, code="stale", reason="late", hand_link=link))
    assert held.sentence == "hand samples are too old: 486 ms at arrival (limit 100 ms)"
    assert held.step == "Keep your hand still: the arm then follows it again. If it goes on holding: swim."


def test_only_who_may_reset_is_told_to() -> None:
    stop = halted(stopped("anna"))
    assert said(stop).second == "the arm does not follow"
    holder, nobody, watching = said(anothers(stop)), said(replace(stop, lease=None)), said(stop, page=2)
    assert holder.step == "Stopped by anna. Only berta can reset it: ask for the robot to do it yourself."
    assert nobody.step == "Stopped by anna. Take the robot, then reset it."
    assert (holder.next, nobody.next, watching.next) == ("lease-button", "lease-button", None)
    assert watching.step == "Stopped by anna. Only the page that operates can reset it."


def test_an_operator_resets_at_whichever_of_the_own_sites_the_lease_is() -> None:
    stop = halted(stopped("berta"))
    elsewhere = replace(stop, lease=LeaseState(6, OPERATOR, 99, stop.t_ns + 5 * NS_PER_S, None))
    assert said(elsewhere).next == "reset"


def test_pictures_that_are_not_live_are_said_before_anything_else() -> None:
    stale = "Look out: side is 3 s old."
    ready = said(READY(), stale=stale)
    assert ready.step.startswith(f"{stale} Wait for live pictures, or engage only if")
    assert ready.next == "engage"  # nothing promises that it is refused
    held = said(READY(), stale=stale, held=True, down=True)
    assert held.step.startswith(f"{stale} Let go first. Wait for live pictures, or hold only if")
    assert said(FOLLOWS(), stale=stale).step == f"{stale} Move your hand: the arm follows."
    assert said(READY()).step == "Press Engage: the arm then follows your hand."


@pytest.mark.parametrize("code", ["outside_box", "out_of_reach", "obstacle"])
def test_at_a_place_that_holds_the_arm_back_the_way_back_is_said_in_words(code: str) -> None:
    limited = replace(FOLLOWS(), code=code)
    assert said(limited, back="towards you and down").step == (
        "Move your hand back towards you and down: the arm goes no further."
    )
    assert said(limited).step == "Move your hand back the way it came: the arm goes no further."


def test_a_hand_that_is_ahead_of_the_arm_may_wait_for_it() -> None:
    ahead = replace(FOLLOWS(), code="saturated")
    assert said(ahead, back="down").step == "Wait for the arm, or move your hand back down."


def test_at_a_limit_one_figure_stands_in_one_place() -> None:
    words = "the hand asks for 45 mm beyond the workspace: the tool stays at its edge"
    far = replace(FOLLOWS(), target=Pose((1.0, 0.0, 1.0), (0.0, 0.0, 0.0, 1.0)))
    assert "from its target" in said(far).sentence
    assert said(replace(far, code="outside_box", reason=words)).sentence == words


def test_a_limit_without_a_place_has_no_direction() -> None:
    assert said(replace(FOLLOWS(), code="ik_limit"), back="down").step == "Turn or move your hand back the way it came."
    assert said(replace(FOLLOWS(), code="velocity"), back="down").step == "Move your hand more slowly."


def test_a_held_arm_asks_for_the_hand_only_where_that_is_the_cause() -> None:
    lost, late = (scene.state(SessionState.HOLDING, code, "why") for code in ("lost", "stale"))
    assert said(lost).step.startswith("Show your hand to the cameras")
    assert said(late).step == "Keep your hand still: the arm then follows it again."


def test_without_a_word_from_the_robots_side_the_stop_that_works_is_named_first() -> None:
    emergency = "press the red emergency stop at the robot"
    silent = said(FOLLOWS(), silent_ns=3 * NS_PER_S)
    assert silent.step.startswith("Press STOP; it may not reach the robot. Have somebody there press the red")
    assert "farhand remote" in silent.step
    assert (silent.second, silent.seat) == ("the arm may still move", "")
    assert emergency in said(None).step
    ended = replace(FOLLOWS(), code="site_ended", reason="the remote site was asked to end")
    assert "start it again" in said(ended, silent_ns=3 * NS_PER_S).step

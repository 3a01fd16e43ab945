"""Halts: a reset clears nothing that its sender was not shown; whoever stopped the arm is named and logged."""

import pytest
from structlog.testing import capture_logs

from common.clock import NS_PER_MS
from common.messages.base import MOST_TEXT
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.drivers.faults import MOST_SENTENCE, STOPPED, FaultCode, RobotFault
from remote_site.reasons import Code
from remote_site.runtime.transition_log import TransitionLog
from remote_site.session.fault_latch import FaultLatch
from remote_site.session.halts import Halts
from remote_site.session.requests import SessionRequest
from remote_site.session.state_machine import Robot
from tests.present import present
from tests.remote_site.remote_loop import RemoteLoop, operator_of
from tests.remote_site.session.session_rig import READY, REST, engaged
from tests.remote_site.session.test_requests import DISENGAGE, ENGAGE, HOLDER, OTHER, RESET, STOP, ask

MAINTENANCE = "maintenance"
PRESSED = RobotFault(FaultCode.EMERGENCY_STOP, "the emergency stop is pressed")
LOST_POWER = RobotFault(FaultCode.ARM_POWER, "no power")


def stopped(*operators):
    """A rig whose arm these have stopped, half a second apart."""
    rig = engaged()
    for operator in operators:
        rig.wait(500)
        ask(rig, STOP, operator)
    rig.wait(4)
    return rig


@pytest.mark.parametrize("gap_ms", [0, 4, 20, 100])
def test_a_reset_clears_no_stop_that_came_after_what_its_sender_was_shown(gap_ms):
    rig = stopped(HOLDER)
    shown_ns = rig.session.halts.newest_ns
    ask(rig, STOP, MAINTENANCE, maintenance=True)
    if gap_ms:
        rig.wait(gap_ms)
    outcome = ask(rig, RESET, seen_ns=shown_ns, robot=Robot(STOPPED, REST))
    assert (outcome.answer.done, outcome.answer.reason.code, outcome.activate) == (False, Code.UNSEEN, False)
    assert outcome.answer.reason.sentence == (
        "this came since, and was not shown when you asked: stopped by maintenance and anna; reset it, then engage. "
        "Look, then reset again"
    )
    rig.frames(40)
    assert ask(rig, ENGAGE).answer.reason.code is Code.STOPPED
    assert ask(rig, RESET).answer.done
    assert ask(rig, ENGAGE).answer.done


def test_a_reset_in_the_tick_of_a_stop_leaves_the_arm_stopped():
    loop = RemoteLoop()
    loop.run(300, lambda _t_ns: (0.0, 0.0, 0.3))
    loop.ask(STOP)
    loop.run(200)
    seen_ns, holder = loop.snapshot.halted_ns, operator_of(7)
    requests = SessionRequest(STOP, MAINTENANCE, maintenance=True), SessionRequest(RESET, holder, seen_ns=seen_ns)
    loop.tick(requests=requests)
    assert [answer.done for answer in loop.snapshot.answers] == [True, False]
    loop.run(100, lambda _t_ns: (0.0, 0.0, 0.3))
    assert loop.ask(ENGAGE).reason.code is Code.STOPPED


@pytest.mark.parametrize("off_ns", [-1, 1, 3600 * 10**9])
def test_only_the_newest_halt_itself_may_be_named(off_ns):
    rig = stopped(OTHER)
    assert ask(rig, RESET, seen_ns=rig.session.halts.newest_ns + off_ns).answer.reason.code is Code.UNSEEN
    assert ask(rig, ENGAGE).answer.reason.code is Code.STOPPED


def test_a_site_that_has_started_again_takes_no_reset_of_what_was_seen_before():
    rig = engaged()
    outcome = ask(rig, RESET, seen_ns=5_000 * NS_PER_MS, robot=Robot(STOPPED, REST))
    assert (outcome.answer.reason.code, outcome.activate) == (Code.UNSEEN, False)
    assert ask(rig, RESET, seen_ns=0).answer.done


def test_everybody_who_has_stopped_the_arm_is_named_the_newest_first():
    rig = stopped(HOLDER)
    assert ask(rig, STOP, MAINTENANCE, maintenance=True).answer.reason.sentence.startswith("stopped by maintenance and")
    assert rig.wait(4).reason.sentence == "stopped by maintenance and anna; reset it, then engage"
    assert rig.session.readiness(rig.now_ns, READY).reason == rig.wait(4).reason
    rig = stopped(HOLDER, OTHER, HOLDER, "carl", "dora")
    assert rig.wait(4).reason.sentence == "stopped by dora, carl, anna and others; reset it, then engage"
    ask(rig, RESET)
    ask(rig, STOP, OTHER)
    assert rig.wait(4).reason.sentence == "stopped by ben; reset it, then engage"


def test_each_stop_is_logged_also_behind_another_and_during_a_fault():
    rig, log = engaged(), TransitionLog()

    def note():
        decision = rig.wait(4)
        log.note(decision.state, decision.reason, rig.session.halts.newest_ns, rig.now_ns)

    note()
    with capture_logs() as lines:
        for operator in (HOLDER, MAINTENANCE, MAINTENANCE):
            ask(rig, STOP, operator)
            note()
            note()
        rig.session.fault("brakes on", rig.now_ns)
        note()
        ask(rig, STOP, OTHER)
        note()
        rig.wait(1000)
        ask(rig, STOP, OTHER)
        note()
    behind = "stopped by ben, maintenance and anna; brakes on; reset it, then engage"
    assert [line["reason"] for line in lines] == [
        "stopped by anna; reset it, then engage",
        "stopped by maintenance and anna; reset it, then engage",
        "stopped by maintenance and anna; brakes on; reset it, then engage",
        behind,
        behind,
    ]


def test_the_first_cause_of_a_fault_is_kept():
    rig = engaged()
    for cause in ("the driver died", "brakes on"):
        rig.session.fault(cause, rig.now_ns)
    assert rig.wait(4).reason.sentence == "the driver died; reset it, then engage"


@pytest.mark.parametrize("first", ["stop", "fault"])
def test_a_stop_shows_with_a_fault_whichever_came_first_and_a_reset_of_one_clears_none(first):
    rig = engaged()
    acts = [lambda: ask(rig, STOP, OTHER), lambda: rig.session.fault("brakes on", rig.now_ns)]
    for act in acts if first == "stop" else acts[::-1]:
        seen_ns = rig.session.halts.newest_ns
        act()
        decision = rig.wait(4)
    assert decision.state is SessionState.FAULT
    assert decision.reason.sentence == "stopped by ben; brakes on; reset it, then engage"
    assert rig.session.readiness(rig.now_ns, READY).reason == decision.reason
    assert ask(rig, RESET, seen_ns=seen_ns).answer.reason.code is Code.UNSEEN
    assert rig.wait(4).state is SessionState.FAULT
    assert ask(rig, RESET).answer.done
    assert rig.frames(40).state is SessionState.DISENGAGED


def test_an_engagement_asked_for_before_a_disengagement_does_not_outlive_it():
    rig = engaged()
    rig.session.request_disengage(rig.now_ns)
    rig.frames(40)
    shown_ns = rig.session.halts.newest_ns
    ask(rig, DISENGAGE)
    rig.frames(1)
    outcome = ask(rig, ENGAGE, seen_ns=shown_ns)
    assert (outcome.answer.done, outcome.answer.reason.code) == (False, Code.UNSEEN)
    assert outcome.answer.reason.sentence.endswith("disengaged on request. Look, then engage again")
    assert rig.frames(40).state is SessionState.DISENGAGED
    assert ask(rig, ENGAGE).answer.done


def test_an_engagement_asked_for_before_a_stop_does_not_outlive_its_reset():
    rig = engaged()
    rig.session.request_disengage(rig.now_ns)
    rig.frames(40)
    shown_ns = rig.session.halts.newest_ns
    ask(rig, STOP, MAINTENANCE, maintenance=True)
    rig.frames(1)
    ask(rig, RESET, MAINTENANCE, maintenance=True)
    rig.frames(1)
    assert ask(rig, ENGAGE, seen_ns=shown_ns).answer.reason.code is Code.UNSEEN
    assert rig.frames(40).state is SessionState.DISENGAGED


def latched(*faults):
    """A rig and its latch, after these faults of a robot that rests, a tick each."""
    rig = engaged()
    latch = FaultLatch(rig.session)
    for fault in (None, *faults):
        rig.wait(4)
        latch.note(fault, rig.now_ns, resting=True)
    return rig, latch


def test_an_emergency_stop_behind_a_fault_is_named_and_has_to_be_seen():
    rig, latch = latched(LOST_POWER)
    shown_ns = rig.session.halts.newest_ns
    rig.wait(4)
    latch.note(PRESSED, rig.now_ns, resting=True)
    assert "stopped by the robot's emergency stop; arm_power: no power" in rig.wait(4).reason.sentence
    assert ask(rig, RESET, seen_ns=shown_ns).answer.reason.code is Code.UNSEEN


def test_a_robot_that_stops_by_itself_behind_a_stop_is_named():
    rig, latch = latched()
    ask(rig, STOP, HOLDER)
    shown_ns = rig.session.halts.newest_ns
    rig.wait(4)
    latch.note(STOPPED, rig.now_ns, resting=True)
    assert rig.wait(4).reason.sentence == "stopped by the robot itself and anna; reset it, then engage"
    assert ask(rig, RESET, seen_ns=shown_ns).answer.reason.code is Code.UNSEEN


def test_a_robot_that_has_stopped_by_itself_is_woken_by_nobody_who_was_not_shown_it():
    rig, _ = latched(STOPPED)
    outcome = ask(rig, RESET, seen_ns=0, robot=Robot(STOPPED, REST))
    assert (outcome.answer.reason.code, outcome.activate) == (Code.UNSEEN, False)
    assert ask(rig, RESET, robot=Robot(STOPPED, REST)).activate


def test_the_longest_names_and_cause_fit_into_a_message_and_ever_more_names_take_no_more_memory():
    halts = Halts()
    for k in range(1000):
        halts.stop(f"{k:064}", k)
    assert len(halts._stoppers) < 10
    assert len(present(halts.reason).sentence) <= MOST_TEXT
    reason = halts.fail(str(RobotFault(FaultCode.COMMAND_TIMEOUT, "x" * MOST_SENTENCE, "y" * 32)), 1000)
    assert len(reason.sentence) <= MOST_TEXT
    assert reason.sentence.endswith("…; reset it, then engage")
    unseen = present(halts.unseen(8, EngagementAction.RESET.value, reason.sentence))
    assert len(unseen.sentence) <= MOST_TEXT
    assert unseen.sentence.endswith("Look, then reset again")

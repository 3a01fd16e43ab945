"""Changes in the log: each state and each fault once, however many ticks it lasts."""

from structlog.testing import capture_logs

from common.messages.robot import SessionState
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.reasons import Code, reason
from remote_site.runtime.transition_log import FaultLog, TransitionLog


def test_every_change_of_the_state_is_logged_once() -> None:
    log = TransitionLog()
    with capture_logs() as lines:
        for state in (SessionState.DISENGAGED, SessionState.ENGAGED, SessionState.DISENGAGED):
            for _ in range(250):
                log.note(state, reason(Code.READY), 0, 0)
    assert [(line["event"], line["state"], line["code"]) for line in lines] == [
        ("session", "disengaged", "ready"),
        ("session", "engaged", "ready"),
        ("session", "disengaged", "ready"),
    ]


def test_a_stop_and_a_reset_are_logged_where_the_arm_is_disengaged_already() -> None:
    log = TransitionLog()
    with capture_logs() as lines:
        for why in (Code.READY, Code.STOPPED, Code.STOPPED, Code.RESET, Code.RESET, Code.READY, Code.STOPPED):
            log.note(SessionState.DISENGAGED, reason(why, operator="maintenance"), 0, 0)
    assert [line["code"] for line in lines] == ["ready", "stopped", "reset", "stopped"]


def test_an_arm_that_holds_and_follows_all_the_time_does_not_fill_the_log() -> None:
    log = TransitionLog()
    with capture_logs() as lines:
        for tick in range(1250):  # five seconds
            state = (SessionState.ENGAGED, SessionState.HOLDING)[tick // 10 % 2]
            log.note(state, reason(Code.READY), 0, tick * 4_000_000)
    assert [line.get("changes", 1) for line in lines] == [1, 25, 25, 25, 25]


def test_every_new_fault_is_logged_once_but_no_refusal() -> None:
    log = FaultLog()
    limit, refused = RobotFault(FaultCode.LIMITS, "too far", "12"), RobotFault(FaultCode.REFUSED, "not now")
    with capture_logs() as lines:
        for fault in (limit, limit, None, refused, limit):
            log.note(fault)
    assert [(line["event"], line["native"], line["log_level"]) for line in lines] == [
        ("robot fault", "12", "warning")
    ] * 2

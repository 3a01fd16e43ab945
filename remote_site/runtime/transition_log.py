"""Logs transitions of the remote site: each once, however many ticks it lasts."""

import structlog

from common.clock import NS_PER_S
from common.messages.robot import SessionState
from common.process.state_lines import StateLines, counted
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.reasons import Code, Reason

ASKED_FOR = (Code.STOPPED, Code.RESET)  # by somebody, so it is logged even where the state stays as it was
BARRED = (Code.STOPPED, Code.FAULT)
APART_NS = NS_PER_S  # between stops of one who has stopped the arm already: pages repeat theirs


class TransitionLog:
    """Logs every change of the session's state, of engaged and holding one a second, every stop and every reset.

    A stop behind another one, or during a fault, is a line of its own; of those of one person in a row one a second is.
    """

    def __init__(self) -> None:
        self._lines = StateLines()
        self._code: Code | None = None
        self._halted_ns = self._barred_ns = 0
        self._barred_by = ""

    def note(self, state: SessionState, reason: Reason, halted_ns: int, now_ns: int) -> None:
        """Note the state of a tick; `halted_ns` is when the newest halt came."""
        changes = self._lines.note(state, now_ns)
        asked = reason.code is not self._code and reason.code in ASKED_FOR
        self._code = reason.code
        if self._is_stop(reason, halted_ns, now_ns) or changes or asked:
            fields = {"state": state.value, "code": reason.code.value, "reason": reason.sentence}
            structlog.get_logger().info("session", **fields, **counted(changes))

    def _is_stop(self, reason: Reason, halted_ns: int, now_ns: int) -> bool:
        """Return whether a halt has come that bars the arm and was not just said."""
        is_new, self._halted_ns = halted_ns != self._halted_ns, halted_ns
        is_same = reason.sentence == self._barred_by and now_ns - self._barred_ns < APART_NS
        if not is_new or is_same or reason.code not in BARRED:
            return False
        self._barred_by, self._barred_ns = reason.sentence, now_ns
        return True


class FaultLog:
    """Logs every new fault of the robot that needs attention."""

    def __init__(self) -> None:
        self._last: RobotFault | None = None

    def note(self, fault: RobotFault | None) -> None:
        """Note the fault of a turn."""
        # a refusal goes to the client, which asks again
        if fault is not None and fault is not self._last and not fault.calm and fault.code is not FaultCode.REFUSED:
            structlog.get_logger().warning(
                "robot fault", code=fault.code.value, native=fault.native, reason=fault.sentence
            )
        self._last = fault

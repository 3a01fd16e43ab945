"""Logs transitions of the remote site: each once, however many ticks it lasts."""

import structlog

from common.messages.robot import SessionState
from common.process.state_lines import StateLines, counted
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.reasons import Code, Reason

ASKED_FOR = (Code.STOPPED, Code.RESET)  # by somebody, so it is logged even where the state stays as it was


class TransitionLog:
    """Logs every change of the session's state, of engaged and holding one a second, every stop and every reset."""

    def __init__(self) -> None:
        self._lines = StateLines()
        self._code: Code | None = None

    def note(self, state: SessionState, reason: Reason, now_ns: int) -> None:
        """Note the state of a tick."""
        changes = self._lines.note(state, now_ns)
        asked = reason.code is not self._code and reason.code in ASKED_FOR
        self._code = reason.code
        if changes or asked:
            fields = {"state": state.value, "code": reason.code.value, "reason": reason.sentence}
            structlog.get_logger().info("session", **fields, **counted(changes))


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

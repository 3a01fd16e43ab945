"""A robot's fault latches the session, and what only ran out while nothing was engaged is mended; pure."""

from common.messages import SessionState
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.safety.state import Session

LAPSES = (FaultCode.COMMAND_TIMEOUT, FaultCode.REFUSED)  # the second while the stop of the first ends


class FaultLatch:
    """Hands every new fault of the robot to the session, once; waiting to be activated is none.

    Nor is a time-out of the commands that found the arm at rest and nobody engaged: control stumbled, as on a machine
    that starts everything at once, and nothing was taken from anybody.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._last: FaultCode | None = None
        self._lapsed = False

    def note(self, fault: RobotFault | None, *, resting: bool) -> bool:
        """The fault of a tick's report, None while the robot takes commands; True asks to activate it anew.

        `resting` is whether the commanded arm rests.
        """
        code = fault.code if fault is not None else None
        if fault is not None and not fault.calm and code is not self._last and not self._lapses(fault, resting):
            self._session.fault(str(fault))
        self._last = code
        self._lapsed = self._lapsed and fault is not None and (fault.calm or fault.code in LAPSES)
        return self._lapsed and code in LAPSES

    def _lapses(self, fault: RobotFault, resting: bool) -> bool:
        if fault.code is FaultCode.COMMAND_TIMEOUT:
            self._lapsed = resting and self._session.state is SessionState.DISENGAGED
        return self._lapsed and fault.code in LAPSES

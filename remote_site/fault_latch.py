"""A robot's fault latches the session: what goes by itself stays a fault until it is reset; pure."""

from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.safety.state import Session


class FaultLatch:
    """Hands every new fault of the robot to the session, once; waiting to be activated is none."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._last: FaultCode | None = None

    def note(self, fault: RobotFault | None) -> None:
        """The fault of a tick's report, None while the robot takes commands."""
        code = fault.code if fault is not None else None
        if fault is not None and not fault.calm and code is not self._last:
            self._session.fault(str(fault))
        self._last = code

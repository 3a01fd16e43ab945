"""A robot's fault latches the session; timeouts while disengaged and at rest recover automatically; pure."""

from common.clock import NS_PER_MS
from common.messages.robot import SessionState
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.session.state_machine import Session

SILENCES = (
    FaultCode.COMMAND_TIMEOUT,
    FaultCode.WATCHDOG,
    FaultCode.PROCESS,
    FaultCode.SILENT,
)  # between control, driver process and robot
ASLEEP = (FaultCode.COMMAND_TIMEOUT, FaultCode.WATCHDOG, FaultCode.REFUSED)  # the last while the stop is ending

# who stops an arm that is barred already, as people read it
EMERGENCY_STOP, ROBOT_ITSELF = "the robot's emergency stop", "the robot itself"

RETRY_NS = 100 * NS_PER_MS  # between activations that are refused one after the other


class FaultLatch:
    """Passes every new fault of the robot to the session, once; waiting to be activated is not a fault.

    Nor is a timeout between control, the driver's process and the robot while the arm rests disengaged, as on a machine
    that starts everything at the same time: no motion was interrupted. While it lasts the robot is not ready, so no
    engagement can begin. A stop of the robot's own behind another stop or fault is passed on as a stop: it shows.
    """

    def __init__(self, session: Session) -> None:
        self._session = session
        self._last: FaultCode | None = None
        self._lapsed = False
        self._asked_ns: int | None = None

    def note(self, fault: RobotFault | None, now_ns: int, *, resting: bool) -> bool:
        """Take the fault of a tick's report, None while the robot takes commands; True if it must be activated again.

        `resting` is whether the commanded arm is at rest. A robot that refuses is asked again ten times a second.
        """
        code = fault.code if fault is not None else None
        if fault is not None and code is not self._last and not self._lapses(fault, resting):
            self._pass_on(fault, now_ns)
        self._last = code
        self._lapsed = self._lapsed and fault is not None and (fault.calm or fault.code in SILENCES + ASLEEP)
        return self._lapsed and code in ASLEEP and self._may_ask(now_ns)

    def activated(self) -> None:
        """The robot is asked to activate: a fault that this does not end is a new one."""
        self._last = None

    def _pass_on(self, fault: RobotFault, now_ns: int) -> None:
        session = self._session
        if fault.calm:
            if fault.code is FaultCode.STOPPED and self._last is None:
                self._stopped_itself(now_ns)
        elif fault.code is FaultCode.EMERGENCY_STOP and session.state is SessionState.FAULT:
            session.stop(EMERGENCY_STOP, now_ns)
        else:
            session.fault(str(fault), now_ns)

    def _stopped_itself(self, now_ns: int) -> None:
        """Show that the robot stopped itself: what barred the arm before would hide it; else its own state shows it."""
        if self._session.barred:
            self._session.stop(ROBOT_ITSELF, now_ns)
        else:
            self._session.halts.note(now_ns)

    def _may_ask(self, now_ns: int) -> bool:
        if self._asked_ns is not None and now_ns - self._asked_ns < RETRY_NS:
            return False
        self._asked_ns = now_ns
        return True

    def _lapses(self, fault: RobotFault, resting: bool) -> bool:
        if fault.code in SILENCES:
            self._lapsed = resting and self._session.state is SessionState.DISENGAGED
        return self._lapsed and fault.code in SILENCES + ASLEEP

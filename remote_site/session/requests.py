"""Requests of operators and maintenance to the session: stop, reset, engage, disengage; pure."""

from dataclasses import dataclass

from common.messages.requests import EngagementAction
from remote_site.reasons import Code, Reason, reason
from remote_site.session.lease import Lease
from remote_site.session.state_machine import Answer, Robot, Session


@dataclass(frozen=True, slots=True)
class SessionRequest:
    """A request as it arrived: the action, who asks for it, and whether it came with maintenance's certificate.

    `seen_ns` is the newest halt that its sender was shown, for a reset and an engagement (`RobotState.halted_ns`).
    """

    action: EngagementAction
    operator: str
    maintenance: bool = False
    seen_ns: int = 0


@dataclass(frozen=True, slots=True)
class Outcome:
    """The answer to a request, and whether the robot has to be activated again for it."""

    answer: Answer
    activate: bool = False


class RequestHandler:
    """Carries out requests: anybody may stop the arm; maintenance may also reset it; the rest is the lease holder's.

    Only a reset clears a fault or a stop, and activates a robot that takes no commands. It clears none that its sender
    was not shown, and an engagement that was asked for before a halt does not outlive it.
    """

    def __init__(self, session: Session) -> None:
        self._session = session

    def handle(self, request: SessionRequest, lease: Lease | None, robot: Robot, now_ns: int) -> Outcome:
        """Carry out one request under the lease in force."""
        action = request.action
        if action is EngagementAction.STOP:
            return Outcome(self._session.stop(request.operator, now_ns))
        refused = _refusal(request, lease)
        if refused is not None:
            return Outcome(Answer(False, refused))
        if action is EngagementAction.DISENGAGE:
            return Outcome(self._session.request_disengage(now_ns))
        unseen = self._session.unseen(request.seen_ns, action.value)
        if unseen is not None and (action is EngagementAction.RESET or not self._session.barred):
            return Outcome(Answer(False, unseen))
        if action is EngagementAction.RESET:
            return Outcome(self._session.reset(), activate=not robot.ready)
        return Outcome(self._session.request_engage(now_ns, robot))


def _refusal(request: SessionRequest, lease: Lease | None) -> Reason | None:
    """Say why this request is not carried out; None for the lease's holder, and for a reset by maintenance."""
    if request.maintenance:
        return None if request.action is EngagementAction.RESET else reason(Code.OPERATORS_ONLY)
    if lease is None:
        return reason(Code.NO_LEASE)
    return None if lease.holder.name == request.operator else reason(Code.NOT_HOLDER, holder=lease.holder)

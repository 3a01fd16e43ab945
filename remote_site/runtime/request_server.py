"""Answers requests about the lease, questions about the clock, and the description of this cell."""

from collections.abc import Callable
from importlib.metadata import version

from common.clock import Clock
from common.errors import MessageError
from common.link.channels import CLOCK, DESCRIBE, LEASE
from common.link.transport import Link
from common.messages.requests import (
    CameraDescription,
    ClockAnswer,
    DescribeQuestion,
    Description,
    JointDescription,
    LeaseAction,
    LeaseReply,
    LeaseRequest,
)
from common.messages.robot import Pose
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code, Reason, reason
from remote_site.session.engagement_intent import INPUTS
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.video.calibration import calibration_of


class RequestServer:
    """Polled by the control loop after each command is written, so no answer delays a command.

    The clock is read at the poll, not when a question arrives: waiting only lengthens that round trip,
    and the quickest of each second counts.
    """

    def __init__(
        self,
        link: Link,
        description: Description,
        leases: LeaseServer,
        clock: Clock,
        refused: Callable[[MessageError], None],
    ) -> None:
        cell = description.cell
        self._clock = clock
        self._leases = leases
        self._description = description
        self._clock_questions = link.answer(CLOCK, cell, refused)
        self._describe_questions = link.answer(DESCRIBE, cell, refused)
        self._lease_requests = link.serve(LEASE, cell, refused)

    def poll(self) -> None:
        """Answer what is waiting, at most one of a kind."""
        now_ns = self._clock.now_ns()
        self._clock_questions.poll(lambda _question: self._time(now_ns))
        self._describe_questions.poll(self._describe)
        self._lease_requests.poll(now_ns, lambda request: answer_lease(self._leases, request, now_ns))

    def _time(self, received_ns: int) -> ClockAnswer:
        return ClockAnswer(received_ns=received_ns, answered_ns=self._clock.now_ns())

    def _describe(self, _question: DescribeQuestion) -> Description:
        return self._description


def answer_lease(leases: LeaseServer, request: LeaseRequest, now_ns: int) -> LeaseReply:
    """Carry out a local site's request about the lease; the reply names the holder."""
    outcome = _act(leases, request, now_ns)
    current = leases.current(now_ns)
    own = current if current is not None and current.holder.session == request.session else None
    answer = outcome if isinstance(outcome, Reason) else _done(request.action, current)
    return LeaseReply(
        id=request.id,
        done=isinstance(outcome, Lease),
        code=answer.code.value,
        reason=answer.sentence,
        lease=own.number if own is not None else 0,
        lasts_ns=own.expires_ns - now_ns if own is not None else 0,
        holder=current.holder.name if current is not None else "",
    )


def _act(leases: LeaseServer, request: LeaseRequest, now_ns: int) -> Lease | Reason:
    number, session = request.lease, request.session
    match request.action:
        case LeaseAction.ACQUIRE:
            return leases.acquire(Holder(session, request.operator), now_ns)
        case LeaseAction.RENEW:
            return leases.renew(number, session, now_ns)
        case LeaseAction.RELEASE:
            return leases.release(number, session, now_ns)
        case LeaseAction.HAND_OVER:
            return leases.hand_over(number, session, now_ns)


def _done(action: LeaseAction, current: Lease | None) -> Reason:
    if action is LeaseAction.HAND_OVER and current is not None:
        return reason(Code.HANDED_OVER, holder=current.holder.name)
    return reason(Code.LEASE_RELEASED if current is None else Code.LEASE_HELD)


def describe(config: RemoteConfig, model: ArmModel, limits: JointLimits, state_hz: float) -> Description:
    """The description of this cell for local sites; limits are those in force."""
    bounds = zip(limits.names, limits.lower.tolist(), limits.upper.tolist(), limits.velocity.tolist(), strict=True)
    video, cell, tool_T_tcp = config.video, config.simulation, config.robot.tool_T_tcp
    links, last_T_tool = model.geometry()
    return Description(
        cell=config.cell,
        software=version("farhand"),
        robot=config.robot.model,
        driver=config.driver.name,
        joints=tuple(
            JointDescription(*row, Pose.from_transform(link.parent_T_joint), link.axis, link.slides)
            for row, link in zip(bounds, links, strict=True)
        ),
        cameras=tuple(
            CameraDescription(c.name, video.width, video.height, video.fps, calibration_of(c, video, cell, tool_T_tcp))
            for c in video.cameras
        ),
        held=config.engagement.mode in INPUTS,
        control_hz=config.control.rate_hz,
        state_hz=state_hz,
        last_T_tool=Pose.from_transform(last_T_tool),
        workspace_min=config.safety.workspace_min_m,
        workspace_max=config.safety.workspace_max_m,
    )

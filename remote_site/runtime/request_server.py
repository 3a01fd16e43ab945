"""Answers requests about the lease, questions about the clock, the description of this cell, and probes."""

from collections.abc import Callable, Sequence
from importlib.metadata import version
from itertools import cycle

import msgspec

from common.clock import Clock
from common.errors import MessageError, ModelError
from common.host_clock import host_time
from common.link.channels import CLOCK, DESCRIBE, LEASE, OWN_CLOCK, OWN_DESCRIBE, TROUBLE
from common.link.transport import Link
from common.messages.hand import Locks
from common.messages.requests import (
    CameraDescription,
    ClockAnswer,
    DescribeQuestion,
    Description,
    JointDescription,
    LeaseAction,
    LeaseReply,
    LeaseRequest,
    MappingDescription,
    TroubleNoted,
)
from common.messages.robot import Asker, Pose
from common.messages.shapes import GripperDescription, ShapesDescription
from common.process.link_log import TroubleLog
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.reasons import Code, Reason, reason
from remote_site.runtime.probe_server import ProbeServer
from remote_site.safety.collision_geometry import read_shapes
from remote_site.safety.described_shapes import describe_capsules, describe_fixtures
from remote_site.session.engagement_intent import INPUTS
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.teleop.config import MappingConfig
from remote_site.video.calibration import calibration_of, size_of

REPORTED_EVENT = "an operator's site reports trouble of the link"


class TroubleReports:
    """Polled by the control loop; no operator's reports keep another's out of the log."""

    def __init__(
        self, link: Link, cell: str, operators: Sequence[str], refused: Callable[[MessageError], None]
    ) -> None:
        self._sources = [
            (link.answer(TROUBLE, cell, refused, operator=operator), TroubleLog(REPORTED_EVENT))
            for operator in operators
        ]

    def poll(self, now_ns: int) -> None:
        """Note one waiting report of each operator."""
        for server, log in self._sources:
            if (told := server.take()) is not None:
                log.note("reported", told.question.reason, now_ns, operator=told.operator)
                told.reply(TroubleNoted())


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
        operators: Sequence[str],
    ) -> None:
        """`operators` are those whose questions and requests are answered, each in turn."""
        cell = description.cell
        self._clock = clock
        self._leases = leases
        self._description = description
        self._clock_questions = [
            link.answer(CLOCK, cell, refused),
            *(link.answer(OWN_CLOCK, cell, refused, operator=operator) for operator in operators),
        ]
        describe_questions = [
            link.answer(DESCRIBE, cell, refused),
            *(link.answer(OWN_DESCRIBE, cell, refused, operator=operator) for operator in operators),
        ]
        self._describe_turns = cycle(describe_questions)
        self._troubles = TroubleReports(link, cell, operators, refused)
        self._probes = ProbeServer(link, cell, operators, clock, refused)
        self._lease_requests = [link.serve(LEASE, cell, refused, operator=operator) for operator in operators]

    def poll(self, *, engaged: bool) -> None:
        """Answer what is waiting, at most one of a kind of each operator, and one question for the description.

        While the arm is `engaged`, probes may not load its link.
        """
        now_ns = self._clock.now_ns()
        for questions in self._clock_questions:
            questions.poll(lambda _question: self._time(now_ns))
        next(self._describe_turns).poll(self._describe)
        for server in self._lease_requests:
            if (asked := server.take(now_ns)) is not None:
                asked.reply(answer_lease(self._leases, asked.question, asked.operator, now_ns))
        self._troubles.poll(now_ns)
        self._probes.poll(engaged=engaged)

    def _time(self, received_ns: int) -> ClockAnswer:
        ahead_ns = host_time().ahead_ns
        return ClockAnswer(received_ns=received_ns, answered_ns=self._clock.now_ns(), ahead_ns=ahead_ns)

    def _describe(self, _question: DescribeQuestion) -> Description:
        return self._description


def answer_lease(leases: LeaseServer, request: LeaseRequest, operator: str, now_ns: int) -> LeaseReply:
    """Carry out a request about the lease that came on this operator's key; the reply names the holder."""
    client = Holder(request.session, operator)
    outcome = _act(leases, request, client, now_ns)
    current = leases.current(now_ns)
    own = current if current is not None and current.holder == client else None
    answer = outcome if isinstance(outcome, Reason) else _done(request.action, current)
    return LeaseReply(
        id=request.id,
        done=isinstance(outcome, Lease),
        code=answer.code.value,
        reason=answer.sentence,
        lease=own.number if own is not None else 0,
        lasts_ns=current.expires_ns - now_ns if current is not None else 0,
        holder=current.holder.name if current is not None else "",
        holder_session=current.holder.session if current is not None else 0,
    )


def _act(leases: LeaseServer, request: LeaseRequest, client: Holder, now_ns: int) -> Lease | Reason:
    number = request.lease
    match request.action:
        case LeaseAction.ACQUIRE:
            return leases.acquire(client, now_ns)
        case LeaseAction.RENEW:
            return leases.renew(number, client, now_ns)
        case LeaseAction.RELEASE:
            return leases.release(number, client, now_ns)
        case LeaseAction.HAND_OVER:
            return leases.hand_over(number, client, _named(request.to), now_ns)


def _named(asker: Asker | None) -> Holder | None:
    return Holder(asker.session, asker.name) if asker is not None else None


def _done(action: LeaseAction, current: Lease | None) -> Reason:
    if action is LeaseAction.HAND_OVER and current is not None:
        return reason(Code.HANDED_OVER, holder=current.holder)
    return reason(Code.LEASE_RELEASED if current is None else Code.LEASE_HELD)


def describe(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> Description:
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
            CameraDescription(c.name, *size_of(c, video), video.fps, calibration_of(c, video, cell, tool_T_tcp))
            for c in video.cameras
        ),
        held=config.engagement.mode in INPUTS,
        control_hz=config.control.rate_hz,
        last_T_tool=Pose.from_transform(last_T_tool),
        workspace_min=config.safety.workspace_min_m,
        workspace_max=config.safety.workspace_max_m,
        mapping=_mapping(config.mapping),
        shapes=_shapes(config, model),
    )


def _mapping(config: MappingConfig) -> MappingDescription:
    return MappingDescription(
        point=config.point,
        scale=config.scale,
        scale_range=config.scale_range,
        base_R_operator=config.base_R_operator,
        locks=Locks(**msgspec.structs.asdict(config.locks)),
    )


def _shapes(config: RemoteConfig, model: ArmModel) -> ShapesDescription:
    robot, collision, grip = config.robot, config.safety.collision, config.grip
    try:
        capsules = describe_capsules(model, read_shapes(robot.urdf, model, robot.capsules, collision))
    except ModelError:  # a recording keeps the arm's URDF, but not the meshes that it names
        capsules = ()
    return ShapesDescription(
        capsules=capsules,
        fixtures=describe_fixtures(collision.fixtures),
        gripper=GripperDescription(grip.closed_mm / 1000, grip.open_mm / 1000),
    )

"""Records of what goes into one control cycle and what comes out of it: frozen, so that a cycle can be replayed."""

from collections.abc import Mapping
from typing import NamedTuple

from common.geometry import Array
from common.messages.hand import ClockSync, OperatorSettings
from common.messages.robot import (
    AssistState,
    Engagement,
    GripperCommand,
    GripperState,
    HandLink,
    MappingReference,
    SessionState,
)
from remote_site.assist.sighting import MarkerSighting
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, Reason
from remote_site.session.lease import LeaseStatus
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import Accepted, NamedSample
from remote_site.session.state_machine import Answer, Robot


class RobotObservation(NamedTuple):
    """The robot as control sees it: measured joints `q` (n,) in rad, why it takes no commands, what was really sent.

    `fault` is None while the robot takes commands; it is also the outcome of an activation. `sent` is the motion that
    the driver was really given last: after a stop of its own, where that stop is. `gripper` is None where none is
    measured. `diverted` is whether the driver has begun such a stop since the last command.
    """

    q: Array
    fault: RobotFault | None
    sent: JointMotion
    gripper: GripperState | None
    diverted: bool = False

    @property
    def ready(self) -> bool:
        """The robot takes commands."""
        return self.fault is None


class CycleInput(NamedTuple):
    """All that a control cycle depends on, besides the cycles before it; samples in order of arrival.

    `site_ready` is whether every process of the remote site has started; `markers` is what is newly known of them.
    """

    now_ns: int
    robot: RobotObservation
    lease: LeaseStatus
    samples: tuple[NamedSample, ...] = ()
    requests: tuple[SessionRequest, ...] = ()
    site_ready: bool = True
    markers: tuple[MarkerSighting, ...] = ()

    def robot_after(self, sent: JointMotion) -> Robot:
        """The robot as the session sees it, once `sent` is the motion it was given last."""
        return Robot(self.robot.fault, sent, self.site_ready, self.robot.diverted)


class Snapshot(NamedTuple):
    """The pipeline after a cycle, for reports and replies.

    `age_limit_ms` is the age up to which samples are obeyed, `speed_scale` the fraction of full speed that it leaves;
    `reason` explains the state, `obeys` is the sample that the motion follows, `target` the tool's target `base_T_tool`
    (4 x 4), `reference` what the next targets count from, `gripper_next` what the next toggle would command, `settings`
    are the operator's in force, None without a lease, `answers` belong to the cycle's requests in their order,
    `rejected` counts refused samples. `hand_link` is None without samples of the lease's holder, and
    `network_ms` is half a round trip as most of them show it. `halted_ns` is when the newest halt came. `assist` is
    None where no targets are configured.
    """

    now_ns: int
    age_limit_ms: float
    speed_scale: float
    state: SessionState
    reason: Reason
    halted_ns: int
    obeys: Accepted | None
    engagement: Engagement | None
    engagements: int
    target: Array
    reference: MappingReference | None
    gripper_toggles: int
    gripper_next: GripperCommand
    readiness: Answer
    held: bool
    settings: OperatorSettings | None
    lease: LeaseStatus
    clock: ClockSync | None
    rejected: Mapping[Code, int]
    hand_link: HandLink | None
    network_ms: float | None
    assist: AssistState | None
    answers: tuple[Answer, ...]


class Command(NamedTuple):
    """The command to the driver: be activated at rest at `activate_at` (n,) rad, or else follow `motion`.

    Only a robot that takes commands is given the motion; the guard has passed it in any case. The `snapshot` describes
    the pipeline after the cycle.
    """

    motion: JointMotion
    gripper: GripperCommand
    activate_at: Array | None
    snapshot: Snapshot

    def joints(self, seq: int, now_ns: int) -> JointCommand:
        """The command in the form that a driver takes."""
        motion = self.motion
        return JointCommand(seq, now_ns, motion.q, motion.dq, motion.ddq, self.gripper)

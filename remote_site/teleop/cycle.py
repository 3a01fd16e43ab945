"""What goes into one control cycle and what comes out of it: frozen records, so that a cycle can be replayed."""

from collections.abc import Mapping
from typing import NamedTuple

from common.geometry import Array
from common.messages.hand import ClockSync, HandArm
from common.messages.robot import Engagement, SessionState
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, Reason
from remote_site.session.lease import LeaseStatus
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import Accepted
from remote_site.session.state_machine import Answer, Robot


class RobotObservation(NamedTuple):
    """The robot as control sees it: measured joints `q` (n,) in rad, why it takes no commands, what was really sent.

    `fault` is None while the robot takes commands; it is also the outcome of an activation. `sent` is the motion that
    the driver was really given last: after a stop of its own, where that stop is.
    """

    q: Array
    fault: RobotFault | None
    sent: JointMotion

    @property
    def ready(self) -> bool:
        """The robot takes commands."""
        return self.fault is None

    def after(self, sent: JointMotion) -> Robot:
        """The robot as the session sees it, once `sent` is the motion it was given last."""
        return Robot(self.fault, sent)


class CycleInput(NamedTuple):
    """All that a control cycle depends on, besides the cycles before it; samples in order of arrival."""

    now_ns: int
    robot: RobotObservation
    lease: LeaseStatus
    samples: tuple[HandArm, ...] = ()
    requests: tuple[SessionRequest, ...] = ()


class Snapshot(NamedTuple):
    """The pipeline after a cycle, for reports and replies.

    `reason` explains the state, `obeys` is the sample that the motion follows, `target` the tool's target
    `base_T_tool` (4 x 4), `answers` belong to the cycle's requests in their order, `rejected` counts refused samples.
    """

    now_ns: int
    state: SessionState
    reason: Reason
    obeys: Accepted | None
    engagement: Engagement | None
    engagements: int
    target: Array
    gripper_toggles: int
    readiness: Answer
    held: bool
    lease: LeaseStatus
    clock: ClockSync | None
    rejected: Mapping[Code, int]
    answers: tuple[Answer, ...]


class Command(NamedTuple):
    """What the driver is to do: be activated at rest at `activate_at` (n,) rad, or else follow `motion`.

    Only a robot that takes commands is given the motion; the guard has passed it in any case. The `snapshot` describes
    the pipeline after the cycle.
    """

    motion: JointMotion
    gripper_open: bool
    activate_at: Array | None
    snapshot: Snapshot

    def joints(self, seq: int, now_ns: int) -> JointCommand:
        """The command in the form that a driver takes."""
        motion = self.motion
        return JointCommand(seq, now_ns, motion.q, motion.dq, motion.ddq, self.gripper_open)

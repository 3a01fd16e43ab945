"""From hand sample to joint motion: intake, session, mapping, inverse kinematics, follower and guard in a row; pure."""

import math
from dataclasses import dataclass

import numpy as np

from common.geometry import Array, quaternion_from_rotation
from common.messages.hand import HandArm
from common.messages.robot import Engagement, Pose, SessionState
from remote_site.config import RemoteConfig
from remote_site.drivers.faults import RobotFault
from remote_site.kinematics.dexterity import FULL, Dexterity
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.jerk_limited import JerkLimitedTracker, leash
from remote_site.motion.target_tracker import choose_target_tracker
from remote_site.reasons import Reason
from remote_site.safety.clearance import ClearanceCheck, Workspace
from remote_site.safety.collision import CollisionModel
from remote_site.safety.collision_avoidance import CollisionAvoidance
from remote_site.safety.guard import Guard, Refused
from remote_site.session.lease import Lease, LeaseServer
from remote_site.session.samples import Accepted
from remote_site.session.state_machine import (
    Action,
    Decision,
    Robot,
    Session,
)
from remote_site.teleop.gripper_toggles import GripperToggles
from remote_site.teleop.mapping import Steering, make_mapping
from remote_site.teleop.sample_validator import SampleValidator


@dataclass(frozen=True, slots=True)
class Step:
    """One tick's outcome: the state with its reason, and the motion that passed the guard."""

    state: SessionState
    reason: Reason
    motion: JointMotion
    obeys: Accepted | None


class TeleopPipeline:
    """Everything between the wire and the driver; feed it samples and what was really sent, time comes in as ns."""

    def __init__(
        self, config: RemoteConfig, model: ArmModel, limits: JointLimits, start: Array, leases: LeaseServer
    ) -> None:
        dt = 1.0 / config.control.rate_hz
        self._control = config.control
        self._model = model
        self.leases = leases
        self.intake = SampleValidator(config.safety, config.mapping.point)
        self.session = Session(config.safety, config.engagement)
        self._mapping = make_mapping(config.mapping)
        self._pursuit = choose_target_tracker(config, model, limits)
        self._dexterity = Dexterity(model, config.control.singularity)
        self._follower = JerkLimitedTracker(limits, dt)
        self._workspace = Workspace(np.array(config.safety.workspace_min_m), np.array(config.safety.workspace_max_m))
        robot, collision = config.robot, config.safety.collision
        self.collision = CollisionModel.from_urdf(robot.urdf, model, robot.capsules, collision)
        self._shield = CollisionAvoidance(self.collision, collision, limits, dt)
        self._guard = Guard(limits, ClearanceCheck(model, self._workspace, self.collision), dt)
        self.gripper = GripperToggles(is_open=True)
        self.sent = JointMotion.at_rest(start)
        self.engagement: Engagement | None = None
        self._latest: Accepted | None = None
        self._aimed: Accepted | None = None
        self._hindrance: Reason | None = None
        self._obstacle: Reason | None = None
        self._slowing = FULL
        self._unjudged = 0
        self.target = model.forward(start)
        self.steering = Steering()
        self.measured: Array | None = None

    def restart_from(self, q: Array) -> None:
        """Go on from an arm at rest at `q` (n,) rad, as after the robot was activated anew."""
        self.sent = JointMotion.at_rest(q)
        self._follower.reset(self.sent)

    def receive(self, sample: HandArm, now_ns: int) -> None:
        """Judge a sample from the wire and note it; what was not sent under the lease in force is only counted."""
        lease = self.leases.in_force(sample.lease, sample.session, now_ns)
        if not isinstance(lease, Lease):
            self.intake.refuse(lease)
            return
        self.session.authorise(lease)
        result = self.intake.accept(sample, now_ns)
        self.session.sample(result)
        if isinstance(result, Accepted):
            intent = sample.intent
            self.steering = Steering(intent.clutch_count, intent.scale, intent.rotation_scale, intent.locks)
            self._latest = result

    def robot(self, fault: RobotFault | None) -> Robot:
        """What the session needs to know of the robot, whose fault is None while it takes commands."""
        return Robot(ready=fault is None, reason=str(fault or ""), resting=self.sent.resting)

    def tick(self, now_ns: int, robot: Robot) -> Step:
        """Decide, and propose the next motion; whatever it is, the guard has passed it."""
        self.session.authorise(self.leases.current(now_ns))
        decision = self.session.tick(now_ns, robot)
        if decision.action is Action.STOP or self._latest is None:
            return self._step(decision, self._guard.stop(self.sent))
        if decision.action is Action.CAPTURE:
            self._capture(self._latest)
        elif self._latest is not self._aimed:
            self._aim(self._latest, now_ns)
            return self._step(decision, self._follow(now_ns, aimed=True))
        return self._step(decision, self._follow(now_ns))

    def _capture(self, latest: Accepted) -> None:
        """Take both origins: nothing that happened before is caught up."""
        base_T_tool = self.target = self._model.forward(self.sent.q)
        self._mapping.steer(self.steering, latest.place, latest.operator_R_hand, base_T_tool)
        self._mapping.engage(latest.place, latest.operator_R_hand, base_T_tool)
        self._pursuit.reset(latest.born_ns, self.sent.q)
        self.gripper.rebase(latest.sample.gripper_toggles)
        self._aimed, self._hindrance, self._slowing, self._unjudged = latest, None, FULL, 0
        self.engagement = Engagement(self.session.engagements, latest.sample.capture_ns, pose_of(base_T_tool))

    def _aim(self, latest: Accepted, now_ns: int) -> None:
        """Turn the newest sample into a joint target inside box, leash and reach."""
        self._aimed = latest
        self.gripper.follow(latest.sample.gripper_toggles)
        self._mapping.steer(self.steering, latest.place, latest.operator_R_hand, self.target)
        measured = self._model.forward(self.measured if self.measured is not None else self.sent.q)
        self._mapping.read(measured)
        target = self._mapping.target(latest.place, latest.operator_R_hand)
        target[:3, 3] = self._workspace.clamp(target[:3, 3])
        leash_rad = math.radians(self._control.leash_deg)
        self.target, saturated = leash(target, measured, self._control.leash_m, leash_rad)
        elbow = self._mapping.elbow(latest.sample.wrist, latest.sample.elbow)
        leashed = saturated is not None
        unreached = self._pursuit.aim(latest.born_ns, self.target, elbow, self.sent.q, now_ns, leashed=leashed)
        self._hindrance = saturated or unreached
        self._unjudged += 1

    def _follow(self, now_ns: int, *, aimed: bool = False) -> JointMotion:
        """One tick towards the target, which has just been aimed at or was before; or into the stop if it must not."""
        self._follower.reset(self.sent)
        q_target, dq_target = self._pursuit.at(now_ns, self.sent.q)
        aside = self._shield.turn_aside(self.sent.q, q_target, dq_target)
        if self._unjudged > aimed:  # once per sample, in the tick after its own, which has enough to do
            self._slowing, self._unjudged = self._dexterity.slowing(self.sent.q, q_target), 0
        self._obstacle = aside.reason or self._slowing.reason
        proposed = self._follower.track(aside.q, aside.dq, aside.speed * self._slowing.fraction * self._speed())
        if isinstance(proposed, Reason):
            self._hindrance = proposed
            return self._guard.stop(self.sent)
        tempered = self._shield.temper(proposed, self.sent, aside.near) if aside.near else proposed
        if tempered is None:
            return self._guard.stop(self.sent)
        verdict = self._guard.check(tempered, self.sent)
        if isinstance(verdict, Refused):
            self._hindrance = verdict.reason
            return self._guard.stop(self.sent)
        return tempered

    def _speed(self) -> float:
        """The share of full speed that the link and the sample's certainty leave."""
        return self.session.speed_scale * (self._aimed.speed if self._aimed is not None else 1.0)

    def _step(self, decision: Decision, motion: JointMotion) -> Step:
        following = decision.action is not Action.STOP
        hindered = self._hindrance or self._obstacle if following else None
        return Step(decision.state, hindered or decision.reason, motion, self._aimed if following else None)


def pose_of(base_T_tool: Array) -> Pose:
    """A transform (4 x 4) as position in m and quaternion."""
    x, y, z = base_T_tool[:3, 3].tolist()
    qx, qy, qz, qw = quaternion_from_rotation(base_T_tool[:3, :3]).tolist()
    return Pose((x, y, z), (qx, qy, qz, qw))

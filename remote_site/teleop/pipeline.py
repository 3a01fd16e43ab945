"""The one control cycle: from hand samples, requests and the robot's state to the next command; pure."""

from dataclasses import replace

import numpy as np

from common.clock import NS_PER_MS
from common.messages.hand import OperatorSettings
from common.messages.robot import GripperCommand
from remote_site.assist.assist import Assist
from remote_site.kinematics.dexterity import Dexterity
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.jerk_limited import JerkLimitedTracker
from remote_site.motion.planner import MotionPlanner
from remote_site.motion.target_tracker import choose_target_tracker
from remote_site.motion.tool_sample import ToolSample
from remote_site.safety.clearance import ClearanceCheck, Workspace
from remote_site.safety.collision import CollisionModel
from remote_site.safety.collision_avoidance import CollisionAvoidance
from remote_site.safety.guard import Guard
from remote_site.session.age_limit import AgeLimit
from remote_site.session.fault_latch import FaultLatch
from remote_site.session.requests import Outcome, RequestHandler
from remote_site.session.samples import Accepted, Rejected
from remote_site.session.state_machine import Action, Decision, Session
from remote_site.teleop.config import PipelineConfig, prediction
from remote_site.teleop.cycle import Command, CycleInput, RobotObservation, Snapshot
from remote_site.teleop.gripper_toggles import GripperToggles
from remote_site.teleop.sample_receiver import SampleReceiver
from remote_site.teleop.tool_target import ToolTarget


class TeleopPipeline:
    """Everything between the wire and the driver: `cycle` once per control tick.

    A cycle depends on nothing but its input and the cycles before it: the same inputs give the same commands.
    """

    def __init__(self, config: PipelineConfig, model: ArmModel, limits: JointLimits) -> None:
        box = Workspace(np.array(config.safety.workspace_min_m), np.array(config.safety.workspace_max_m))
        self._samples = SampleReceiver(config.safety, config.mapping.point)
        self._session = Session(config.safety, config.engagement, self._samples.age_limit)
        self._faults = FaultLatch(self._session)
        self._requests = RequestHandler(self._session)
        self._target = ToolTarget(config.mapping, config.control, box, model, config.robot.start)
        self._planner = _planner(config, model, limits, box)
        self._gripper = GripperToggles()
        self._assist = Assist(config.assist)
        self._led = False
        self._aimed: Accepted | None = None

    def cycle(self, given: CycleInput) -> Command:
        """One tick: take samples and requests, decide, and plan the next motion."""
        now_ns, robot, lease = given.now_ns, given.robot, given.lease.lease
        resting = not robot.ready and robot.sent.resting  # it matters for a fault only
        activate = self._faults.note(robot.fault, now_ns, resting=resting)
        sent = JointMotion.at_rest(robot.q) if activate else robot.sent
        self._session.authorise(lease)
        for named in given.samples:
            self._take(self._samples.receive(named, lease, now_ns), now_ns)
        self._session.limit_age(self._samples.age_limit)
        self._assist.see(given.markers)
        self._assist.tick(now_ns)
        outcomes = []
        for request in given.requests:
            outcome = self._requests.handle(request, lease, given.robot_after(sent), now_ns)
            sent = JointMotion.at_rest(robot.q) if outcome.activate else sent
            outcomes.append(outcome)
        limit = self._samples.settle(self._planner.pace(sent))
        self._session.limit_age(limit)
        decision = self._session.tick(now_ns, given.robot_after(sent))
        motion = self._plan(decision, limit, robot, sent, now_ns)
        activate = activate or any(outcome.activate for outcome in outcomes)
        if activate or self._session.barred:
            self._gripper.keep()
        if activate:
            self._faults.activated()
        snapshot = self._snapshot(given, decision, limit, outcomes, motion if robot.ready else sent)
        return Command(motion, self._gripper.command, sent.q if activate else None, snapshot)

    def _take(self, result: Accepted | Rejected | None, now_ns: int) -> None:
        """Tell session, assist and gripper of a judged sample, None where it was not judged."""
        if result is None:
            return
        self._session.sample(result)
        if result.sample is not None:
            self._assist.observe_intent(result.sample.intent, now_ns)
        if isinstance(result, Rejected) and result.sample is not None:
            self._gripper.interrupt()

    def _plan(
        self, decision: Decision, limit: AgeLimit, robot: RobotObservation, sent: JointMotion, now_ns: int
    ) -> JointMotion:
        """The next motion: into the stop, or from new origins, or towards the newest sample."""
        latest = self._samples.latest
        if decision.action is not Action.FOLLOW:
            self._assist.halt(now_ns)
            self._led = False
        if decision.action is Action.STOP or latest is None:
            return self._planner.stop(sent)
        aimed, settings = False, self._target.bounded(self._session.page.settings)
        speed = limit.speed_scale * latest.speed
        if decision.action in (Action.CAPTURE, Action.RESUME):
            self._begin(latest, settings, decision, sent)
        elif latest is not self._aimed:
            self._gripper.follow(latest.sample, settings.revision, robot.gripper)
            target = self._tool_sample(latest, settings, robot, now_ns)
            self._planner.aim(replace(target, stretch=limit.stretch, speed=speed))
            aimed = True
        self._aimed = latest
        return self._planner.follow(now_ns, sent, speed, aimed=aimed)

    def _tool_sample(
        self, latest: Accepted, settings: OperatorSettings, robot: RobotObservation, now_ns: int
    ) -> ToolSample:
        """The tool's next target: led by the assist while the operator asks for it, else by the hand."""
        target, q, q_sent = self._target, robot.q, robot.sent.q
        can_grasp = self._gripper.next(robot.gripper) is not GripperCommand.OPEN
        led = self._assist.step(
            latest.position, latest.sample.capture_ns, target.base_T_tool, target.measured(q), now_ns, can_grasp
        )
        released, self._led = self._led and led is None, led is not None
        if led is not None:
            return target.lead(led, latest, q_sent, q, now_ns)
        if released:
            target.rebase(latest, settings)
        return target.aim(latest, settings, q_sent, q, now_ns)

    def _begin(self, latest: Accepted, settings: OperatorSettings, decision: Decision, sent: JointMotion) -> None:
        """Follow from rest: from the origins of before a short hold, or from new ones."""
        held_since_ns = decision.held_since_ns
        resumes = decision.action is Action.RESUME and self._target.resume(latest, settings, sent.q, held_since_ns)
        if not resumes:
            self._target.capture(latest, settings, sent.q, self._session.engagements, clutched=decision.clutched)
        self._planner.reset(latest.born_ns, sent.q)
        self._gripper.rebase(latest.sample, settings.revision)

    def _snapshot(
        self, given: CycleInput, decision: Decision, limit: AgeLimit, outcomes: list[Outcome], sent: JointMotion
    ) -> Snapshot:
        following = decision.action is not Action.STOP
        session, target, now_ns = self._session, self._target, given.now_ns
        return Snapshot(
            now_ns=now_ns,
            age_limit_ms=limit.soft_ns / NS_PER_MS,
            speed_scale=limit.speed_scale,
            state=decision.state,
            reason=(self._planner.hindrance if following else None) or decision.reason,
            halted_ns=session.halts.newest_ns,
            obeys=self._aimed if following else None,
            engagement=target.engagement,
            engagements=session.engagements,
            target=target.base_T_tool,
            reference=target.reference,
            gripper_toggles=self._gripper.applied,
            gripper_next=self._gripper.next(given.robot.gripper),
            readiness=session.readiness(now_ns, given.robot_after(sent)),
            held=session.held,
            settings=target.bounded(session.page.settings) if given.lease.lease is not None else None,
            lease=given.lease,
            clock=self._samples.clock,
            rejected=self._samples.rejected,
            hand_link=self._samples.figures(now_ns),
            network_ms=self._samples.network_ms,
            assist=self._assist.state(),
            answers=tuple(outcome.answer for outcome in outcomes),
        )


def _planner(config: PipelineConfig, model: ArmModel, limits: JointLimits, box: Workspace) -> MotionPlanner:
    robot, control, collision = config.robot, config.control, config.safety.collision
    dt = 1.0 / control.rate_hz
    bodies = CollisionModel.from_urdf(robot.urdf, model, robot.capsules, collision)
    return MotionPlanner(
        choose_target_tracker(robot, prediction(config), model, limits),
        Dexterity(model, control.singularity),
        CollisionAvoidance(bodies, collision, limits, dt),
        JerkLimitedTracker(limits, dt),
        Guard(limits, ClearanceCheck(model, box, bodies), dt),
    )

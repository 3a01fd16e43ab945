"""Inverse kinematics of the tool's target: in closed form at every sample, or step by step for any arm; pure."""

import math
from dataclasses import replace
from typing import Protocol

import numpy as np
import pinocchio as pin

from common.clock import NS_PER_S
from common.errors import ModelError
from common.geometry import Array, pose_between, transform, unwound
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.differential import DifferentialInverse, Move
from remote_site.kinematics.inverse import Solution, SphericalWristInverse, Unreachable
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.config import ControlConfig
from remote_site.motion.delayed_target import DelayedTarget, Followed
from remote_site.motion.target_predictor import SLOWEST, TargetPredictor, joint_target_predictor
from remote_site.motion.tool_sample import ToolSample
from remote_site.motion.waiting_target import WaitingTarget
from remote_site.reasons import Code, Reason, reason

SPACING_RAD = 0.03  # of the solutions on the way: so close, joints that move straight keep the tool on it
MOST = 12  # solutions from one target to the next
UNWIND_S = 5.0  # 1/s: how fast a target that the joints do not follow comes back to them
SHORTEST_S, LONGEST_S = 0.01, 0.2  # between two targets, for the pace of joint 4
FAR_M, FAR_RAD = 0.01, 0.05  # a tool that stays further from its target is reported


class PathInverse:
    """The closed form at each target of the tool, and on the straight way there, turned in proportion.

    `q` (6,) in rad is the newest solution.
    """

    def __init__(self, inverse: SphericalWristInverse) -> None:
        self._inverse = inverse
        self._pose, self.q = np.eye(4), np.zeros(6)

    def reset(self, base_T_tool: Array, q: Array) -> None:
        """Begin at the tool's pose (4 x 4), where the joints are at `q` (6,) rad."""
        self._pose, self.q = base_T_tool, q

    def to(self, base_T_target: Array, elapsed_s: float, speed: float) -> Solution | Unreachable:
        """The solution for a target (4 x 4), `elapsed_s` after the last one, at a fraction of full speed."""
        found = self._inverse.nearest(base_T_target, self.q, elapsed_s, speed)
        if isinstance(found, Solution):
            self._pose, self.q = base_T_target, found.q
        return found

    def along(self, base_T_target: Array, elapsed_s: float, speed: float) -> list[Solution] | Unreachable:
        """The same as `to`, after the solutions on the way to it; those out of reach are left out.

        Each is the nearest to the one before, so that joint 4, which only goes as far as the time allows where the
        wrist is straight, does not swing between what is solved at once and what is solved step by step.
        """
        pose, q = self._pose, self.q
        at_once = self.to(base_T_target, elapsed_s, speed)
        if isinstance(at_once, Unreachable):
            return at_once
        steps = min(math.ceil(float(np.abs(at_once.q - q).max()) / SPACING_RAD), MOST)
        found: list[Solution] = []
        for k in range(steps if steps > 1 else 0):
            on_the_way = pose_between(pose, base_T_target, (k + 1) / steps)
            solution = self._inverse.nearest(on_the_way, found[-1].q if found else q, elapsed_s / steps, speed)
            if isinstance(solution, Solution):
                found.append(solution)
            elif k + 1 == steps:
                found.append(at_once)
        found = found or [at_once]
        self.q = found[-1].q
        return found


class TargetTracker(Protocol):
    """Turns targets of the tool into targets of the joints.

    `aim` takes a new target, whatever the arm's posture; the answer is why it cannot be reached.
    `at` is asked once per tick: how the joints' target moves, for an arm that `sent` leads at the fraction `speed` of
    its full speed; `barred` while an obstacle keeps the arm from it.
    """

    def reset(self, t_ns: int, q: Array) -> None: ...

    def aim(self, target: ToolSample) -> Reason | None: ...

    def at(self, now_ns: int, sent: JointMotion, speed: float, *, barred: bool = False) -> JointMotion: ...


class ClosedFormTracker:
    """The closed form at every sample, and a predicted joint target between samples that waits for the joints."""

    def __init__(
        self, model: ArmModel, inverse: PathInverse, predictor: TargetPredictor, waiting: WaitingTarget
    ) -> None:
        self._model, self._inverse = model, inverse
        self._predictor, self._waiting = predictor, waiting
        self._solved_ns = 0

    def reset(self, t_ns: int, q: Array) -> None:
        """Rest at `q`."""
        self._solved_ns = t_ns
        self._inverse.reset(self._model.forward(q), q)
        self._predictor.reset(t_ns, q)
        self._waiting.reset()

    def aim(self, target: ToolSample) -> Reason | None:
        """Solve for the target; without a solution the joints keep the one before. The elbow follows the branch.

        The solution is the nearest to the one before: near to an arm that lags, joint 4 would be paced from where the
        arm is, and the target would swing with the arm.
        """
        solution = self._solved(target)
        if not isinstance(solution, Solution):
            self._waiting.halt(self._inverse.q)
            self._predictor.note_arrival(target)
            return solution.reason
        self._solved_ns = target.t_ns
        self._predictor.aim(target, solution.q)
        return None

    def _solved(self, target: ToolSample) -> Solution | Unreachable:
        """The target's solution; while the joints' target waits, it gets those on the way too."""
        elapsed_s = min(max((target.t_ns - self._solved_ns) / NS_PER_S, SHORTEST_S), LONGEST_S)
        speed = max(target.speed, SLOWEST)
        if not self._waiting.waits:
            return self._inverse.to(target.base_T_target, elapsed_s, speed)
        found = self._inverse.along(target.base_T_target, elapsed_s, speed)
        if isinstance(found, Unreachable):
            return found
        for left, solution in zip(reversed(range(len(found))), found, strict=True):
            self._waiting.add(solution.q, target.t_ns - round(left * elapsed_s / len(found) * NS_PER_S))
        return found[-1]

    def at(self, now_ns: int, sent: JointMotion, speed: float, *, barred: bool = False) -> JointMotion:
        """The predicted target, or that on its path, whatever the arm's posture."""
        target, hand_ns = JointMotion(*self._predictor.at(now_ns)), now_ns - self._predictor.delay_ns
        return self._waiting.follow(hand_ns, target, sent, max(speed, SLOWEST), barred=barred)


class DifferentialTracker:
    """A predicted target of the tool, and one step of differential inverse kinematics towards it in every tick."""

    def __init__(self, robot: RobotConfig, control: ControlConfig, model: ArmModel, limits: JointLimits) -> None:
        self._model = model
        self._inverse = DifferentialInverse(model, limits, control.solver, control.singularity, robot.start)
        self._predictor = TargetPredictor(6, control)
        self._dt = 1.0 / control.rate_hz
        self._lead = control.solver.lead_rad
        self._delayed = DelayedTarget(limits, self._dt)
        self.reset(0, robot.start)

    def reset(self, t_ns: int, q: Array) -> None:
        """Rest at `q`; turns of the tool count from here."""
        base_T_tool = self._model.forward(q)
        self._turned_from = base_T_tool[:3, :3].copy()
        self._pose = np.concatenate([base_T_tool[:3, 3], np.zeros(3)])
        self._predictor.reset(t_ns, self._pose)
        self._delayed.reset()
        self._move = Move.at_rest(q)
        self._elbow: Array | None = None
        self._off: Reason | None = None
        if self._inverse.swivel is not None:
            self._inverse.swivel.forget()

    def aim(self, target: ToolSample) -> Reason | None:
        """Take the tool's target; the answer is what the last steps could not reach."""
        base_T_target, elbow = target.base_T_target, target.elbow
        if not (np.isfinite(base_T_target).all() and (elbow is None or np.isfinite(elbow).all())):
            return reason(Code.NOT_A_POSE)
        turn = unwound(pin.log3(base_T_target[:3, :3] @ self._turned_from.T), self._pose[3:])
        self._pose = np.concatenate([base_T_target[:3, 3], turn])
        self._predictor.aim(target, self._pose, moving=target.leashed is None)
        self._delayed.path.add(target.t_ns, self._pose)
        self._elbow = elbow if elbow is not None else self._elbow
        return self._off

    def at(self, now_ns: int, sent: JointMotion, speed: float, *, barred: bool = False) -> JointMotion:
        """One step towards the target, predicted or late, from joints that never run away from the arm."""
        q, delayed, last = sent.q, self._delayed, self._move
        pose, rate, _ = self._predictor.at(now_ns)
        delayed.path.predict(pose, rate)
        pose, rate = delayed.path.at(now_ns - self._predictor.delay_ns, delayed.delay_s)
        arm = Followed(last.dq, last.asked, self._model.position(q) - pose[:3])
        delayed.advance(arm, max(speed, SLOWEST), rate, barred=barred)
        target = transform(pin.exp3(pose[3:]) @ self._turned_from, pose[:3])
        twist = np.concatenate([rate[:3], pin.Jexp3(pose[3:]).T @ rate[3:]])
        kept = np.minimum(np.maximum(last.q, q - self._lead), q + self._lead)
        kept = kept + UNWIND_S * self._dt * (q - kept)
        start = replace(last, q=kept)
        move = self._move = self._inverse.step(start, target, twist, delayed.pace, self._dt, self._elbow)
        far = move.off_m > FAR_M or move.off_rad > FAR_RAD
        off = {"distance_mm": move.off_m * 1e3, "angle_deg": float(np.degrees(move.off_rad))}
        self._off = reason(Code.UNREACHED, **off) if far else None
        return JointMotion(move.q, move.dq, np.zeros(len(q)))  # what the null space adds is no motion to plan ahead


def choose_target_tracker(
    robot: RobotConfig, control: ControlConfig, model: ArmModel, limits: JointLimits
) -> TargetTracker:
    """The configured kinematics; ModelError when the closed form is required of an arm that it does not fit."""
    wanted = robot.kinematics
    if wanted == "general":
        return DifferentialTracker(robot, control, model, limits)
    try:
        inverse = SphericalWristInverse(model, limits, robot.stance)
        inverse.verify()
    except ModelError as error:
        if wanted == "closed":
            raise ModelError(f'robot.kinematics = "closed": {error}; or set it to "general"') from error
        return DifferentialTracker(robot, control, model, limits)
    inverse.check_branch(robot.start)
    predictor = joint_target_predictor(model, limits, control)
    waiting = WaitingTarget(model, limits, 1.0 / control.rate_hz)
    return ClosedFormTracker(model, PathInverse(inverse), predictor, waiting)

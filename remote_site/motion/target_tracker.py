"""From the tool's target to the joints': by closed form at every sample, or step by step for any arm; pure."""

from dataclasses import replace
from typing import Protocol

import numpy as np
import pinocchio as pin
from msgspec.structs import replace as replace_struct

from common.errors import ModelError
from common.geometry import Array, transform, unwound
from remote_site.config import RemoteConfig
from remote_site.kinematics.differential import DifferentialInverse, Move
from remote_site.kinematics.inverse import Solution, SphericalWristInverse
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.motion.target_predictor import JointTargetPredictor, TargetPredictor
from remote_site.reasons import Code, Reason, reason
from remote_site.safety.config import FULL_SPEED_MS

UNWIND_S = 5.0  # 1/s: how fast a target that the joints do not follow comes back to them
FAR_M, FAR_RAD = 0.01, 0.05  # a tool further from its target than the solver brings it is worth a word


class TargetTracker(Protocol):
    """Leads the joints after the tool's target.

    `aim` takes a target (4 x 4) for the time `t_ns`, known at `now_ns`, an arm at `q` (n,) rad, the operator's elbow
    from the wrist (3,) in the base's axes if it is seen, and whether the leash holds the target, so that it moves with
    the arm only; the answer says why a target cannot be followed.
    `at` is asked once per tick: the joints' target (n,) in rad and its speed in rad/s, for an arm at `q`.
    """

    def reset(self, t_ns: int, q: Array) -> None: ...

    def aim(
        self, t_ns: int, base_T_target: Array, elbow: Array | None, q: Array, now_ns: int, *, leashed: bool
    ) -> Reason | None: ...

    def at(self, now_ns: int, q: Array) -> tuple[Array, Array]: ...


class ClosedFormTracker:
    """The closed form at every sample, and a course of the joints between them."""

    def __init__(self, inverse: SphericalWristInverse, course: JointTargetPredictor) -> None:
        self._inverse = inverse
        self._course = course

    def reset(self, t_ns: int, q: Array) -> None:
        """Rest at `q`."""
        self._course.reset(t_ns, q)

    def aim(
        self, t_ns: int, base_T_target: Array, elbow: Array | None, q: Array, now_ns: int, *, leashed: bool
    ) -> Reason | None:
        """Solve for the target; without a solution the joints go on to the one before. The elbow is the stance's."""
        del elbow, leashed
        solution = self._inverse.nearest(base_T_target, q)
        if not isinstance(solution, Solution):
            return solution.reason
        self._course.aim(t_ns, solution.q, now_ns)
        return None

    def at(self, now_ns: int, q: Array) -> tuple[Array, Array]:
        """Where the course is."""
        del q
        return self._course.at(now_ns)


class DifferentialTracker:
    """A course of the tool, and one step of differential inverse kinematics towards it in every tick."""

    def __init__(self, config: RemoteConfig, model: ArmModel, limits: JointLimits) -> None:
        control = config.control
        self._model = model
        self._inverse = DifferentialInverse(model, limits, control.solver, control.singularity, config.robot.start)
        self._course = TargetPredictor(6, control)
        self._dt = 1.0 / control.rate_hz
        self._lead = control.solver.lead_rad
        self.reset(0, config.robot.start)

    def reset(self, t_ns: int, q: Array) -> None:
        """Rest at `q`; turns of the tool count from here."""
        base_T_tool = self._model.forward(q)
        self._turned_from = base_T_tool[:3, :3].copy()
        self._place = np.concatenate([base_T_tool[:3, 3], np.zeros(3)])
        self._course.reset(t_ns, self._place)
        self._move = Move(q.copy(), np.zeros(len(q)), 0.0, 0.0)
        self._elbow: Array | None = None
        self._off: Reason | None = None
        if self._inverse.swivel is not None:
            self._inverse.swivel.forget()

    def aim(
        self, t_ns: int, base_T_target: Array, elbow: Array | None, q: Array, now_ns: int, *, leashed: bool
    ) -> Reason | None:
        """Set the tool's course; the answer is what the last steps could not reach."""
        del q
        if not (np.isfinite(base_T_target).all() and (elbow is None or np.isfinite(elbow).all())):
            return reason(Code.NOT_A_POSE)
        turn = unwound(pin.log3(base_T_target[:3, :3] @ self._turned_from.T), self._place[3:])
        self._place = np.concatenate([base_T_target[:3, 3], turn])
        self._course.aim(t_ns, self._place, now_ns, moving=not leashed)
        self._elbow = elbow if elbow is not None else self._elbow
        return self._off

    def at(self, now_ns: int, q: Array) -> tuple[Array, Array]:
        """One step towards the course, from joints that never run away from the arm."""
        place, rate = self._course.at(now_ns)
        target = transform(pin.exp3(place[3:]) @ self._turned_from, place[:3])
        twist = np.concatenate([rate[:3], pin.Jexp3(place[3:]).T @ rate[3:]])
        last = self._move
        kept = np.minimum(np.maximum(last.q, q - self._lead), q + self._lead)
        kept = kept + UNWIND_S * self._dt * (q - kept)
        move = self._move = self._inverse.step(replace(last, q=kept), target, twist, self._dt, self._elbow)
        far = move.off_m > FAR_M or move.off_rad > FAR_RAD
        off = {"distance_mm": move.off_m * 1e3, "angle_deg": float(np.degrees(move.off_rad))}
        self._off = reason(Code.UNREACHED, **off) if far else None
        return move.q, move.dq


def choose_target_tracker(config: RemoteConfig, model: ArmModel, limits: JointLimits) -> TargetTracker:
    """The configured kinematics; ModelError when the closed form is asked of an arm that it does not fit.

    A target that is told from where the arm is moves with the arm: carried on beyond its sample it would run away. Any
    other is carried on in proportion longer for an arm that a long T_soft has made slower.
    """
    carried_ms = 0.0 if config.mapping.command == "incremental" else config.control.predict_ms
    carried_ms *= max(config.safety.t_soft_ms / FULL_SPEED_MS, 1.0)
    config = replace_struct(config, control=replace_struct(config.control, predict_ms=carried_ms))
    wanted = config.robot.kinematics
    if wanted == "general":
        return DifferentialTracker(config, model, limits)
    try:
        inverse = SphericalWristInverse(model, limits, config.robot.stance)
        inverse.verify()
    except ModelError as error:
        if wanted == "closed":
            raise ModelError(f'robot.kinematics = "closed": {error}; or set it to "general"') from error
        return DifferentialTracker(config, model, limits)
    inverse.check_branch(config.robot.start)
    return ClosedFormTracker(inverse, JointTargetPredictor(limits, config.control))

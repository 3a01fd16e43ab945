"""Inverse kinematics of any serial arm, one step at a time: damped least squares within bounds of joint speeds."""

import math
from dataclasses import dataclass

import daqp
import numpy as np
import pinocchio as pin
from scipy.linalg import lapack

from common.geometry import Array
from remote_site.kinematics.config import SingularityConfig, SolverConfig
from remote_site.kinematics.dexterity import task_weights
from remote_site.kinematics.limits import TARGET_SPEED, JointLimits, stoppable
from remote_site.kinematics.model import ArmModel
from remote_site.kinematics.swivel import Swivel

BRAKE_M_S2, BRAKE_RAD_S2 = 1.5, 5.0  # an error decays no faster than the arm can stop at its end
ERROR_DAMPING = 0.5  # damping by the squared error: the arm comes to rest before a target out of reach
FREE_WEIGHT = 1e-4  # of null-space motion, when a joint's speed has to be reduced
ACCELERATE = 0.8  # of a joint's acceleration: the tracker must be quicker than its target to catch up
NEAR_LIMITS = 0.7  # of the speed from which a joint could just stop
RETURN_S = 10.0  # 1/s: the speed of a joint beside its limit by its distance
SOLVED = 1
TINY = 1e-12


@dataclass(frozen=True, slots=True)
class Move:
    """One step: joint positions (n,) in rad and speeds in rad/s, and how far off the tool was before it.

    `asked` (n,) in rad/s are the speeds that the target's own motion asks for, whatever the joints can.
    """

    q: Array
    dq: Array
    off_m: float
    off_rad: float
    asked: Array

    @classmethod
    def at_rest(cls, q: Array) -> "Move":
        """Make the step of an arm that rests at `q` (n,), on its target."""
        still = np.zeros(len(q))
        return cls(q.copy(), still, 0.0, 0.0, still)


class DifferentialInverse:
    """Follows a moving pose, joints within their limits and speeds; the null space serves the elbow or the posture.

    Directions that a nearly singular posture has lost are damped one by one, the others stay exact while the tool is
    on its target; the larger its error, the more all are damped (Levenberg-Marquardt after Sugihara). Where a joint
    would be too fast or beyond its limit, a quadratic program (daqp) finds the speeds nearest to those wanted, as
    weighted at the tool. A joint outside its limit returns at its own speed.
    """

    def __init__(
        self, model: ArmModel, limits: JointLimits, solver: SolverConfig, singularity: SingularityConfig, posture: Array
    ) -> None:
        self._model = model
        self._data = model.pin_model.createData()
        self._gain, self._posture_gain = solver.gain_s, solver.posture_gain_s
        self._weights = task_weights(singularity.radius_m)
        self._damp = singularity.damp_condition
        self._posture = posture
        self._fastest = TARGET_SPEED * limits.velocity
        self.swivel = Swivel.of(model, solver)
        far = np.maximum(limits.velocity / RETURN_S, limits.velocity**2 / limits.acceleration) / NEAR_LIMITS**2
        columns = limits.lower, limits.upper, far, self._fastest, limits.acceleration, limits.jerk
        self._joints = list(zip(*(column.tolist() for column in columns), strict=True))
        n = len(limits.names)
        self._no_rows, self._sense = np.zeros((0, n)), np.zeros(n, dtype=np.int32)

    def step(self, last: Move, base_T_target: Array, twist: Array, pace: float, dt: float, elbow: Array | None) -> Move:
        """From the last step towards a finite pose (4 x 4), for `dt` s.

        It moves with `twist` (6,) in m/s and rad/s at `pace` 1, and at another pace that many times as fast. `elbow`
        (3,) in m is the operator's, from the wrist, in the base's axes; None if it was never seen.
        """
        q, model, frame = last.q, self._model.pin_model, self._model.tcp_frame
        pin.computeJointJacobians(model, self._data, q)
        pose = pin.updateFramePlacement(model, self._data, frame)
        jacobian = pin.getFrameJacobian(model, self._data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
        off = np.concatenate(
            [base_T_target[:3, 3] - pose.translation, pin.log3(base_T_target[:3, :3] @ pose.rotation.T)]
        )
        off_m, off_rad = math.sqrt(float(off[:3] @ off[:3])), math.sqrt(float(off[3:] @ off[3:]))
        moving = pace * twist
        back = (off - dt * moving) * min(self._gain, _rate(off_m, BRAKE_M_S2), _rate(off_rad, BRAKE_RAD_S2))
        error = self._weights[:, 0] * off
        dq, asked = self._speeds(last, jacobian, moving + back, twist, float(error @ error), dt, elbow)
        return Move(q + dt * dq, dq, off_m, off_rad, asked)

    def _speeds(
        self,
        last: Move,
        jacobian: Array,
        wanted: Array,
        twist: Array,
        error_square: float,
        dt: float,
        elbow: Array | None,
    ) -> tuple[Array, Array]:
        """The joints' speeds (n,) for what is wanted (6,), and those that a twist (6,) on the target would need."""
        weighted = self._weights * jacobian
        u, sigma, vt, failed = lapack.dgesdd(weighted)
        if failed:
            return np.zeros(len(last.q)), np.zeros(len(last.q))
        least = sigma[0] / self._damp
        kept = np.maximum(sigma, least) ** 2
        squares = kept + ERROR_DAMPING * error_square
        rows, columns = vt[: len(sigma)], u.T[: len(sigma)] * self._weights[:, 0]
        asked = (columns @ twist * sigma / kept) @ rows
        dq: Array = (columns @ wanted * sigma / squares) @ rows
        dq += self._free(last.q, vt, rows, sigma**2 / squares, elbow, dt)
        lowest, highest = self._box(last, dt)
        if (dq < lowest).any() or (dq > highest).any():
            weights = np.concatenate([squares, np.full(len(last.q) - len(sigma), FREE_WEIGHT)])
            weight = (vt.T * weights) @ vt
            found, _, status, _ = daqp.solve(weight, -weight @ dq, self._no_rows, highest, lowest, self._sense)
            dq = np.minimum(np.maximum(found if status == SOLVED else dq, lowest), highest)
        return dq, asked

    def _free(self, q: Array, vt: Array, rows: Array, taken: Array, elbow: Array | None, dt: float) -> Array:
        """Null-space speeds (n,): the operator's elbow followed, or back to the posture."""
        if elbow is not None and self.swivel is not None:
            free = vt[-1]
            along: Array = free * self.swivel.rate(self._data, self._data.J, free, elbow, self._fastest, dt)
            return along
        back = self._posture_gain * (self._posture - q)
        rest: Array = back - (taken * (rows @ back)) @ rows
        return rest

    def _box(self, last: Move, dt: float) -> tuple[Array, Array]:
        """The lowest and highest speeds (n,) that a joint can reach and that let it stop before its limit.

        Outside its limit a joint only returns.
        """
        lowest, highest = [], []
        for q, dq, joint in zip(last.q.tolist(), last.dq.tolist(), self._joints, strict=True):
            lower, upper, far, fastest, acceleration, jerk = joint
            change = ACCELERATE * dt * acceleration
            down = fastest if q - lower > far else _approach_speed(q - lower, fastest, acceleration, jerk)
            up = fastest if upper - q > far else _approach_speed(upper - q, fastest, acceleration, jerk)
            lowest.append(min(max(dq - change, -down), up))
            highest.append(min(max(dq + change, -down), up))
        return np.array(lowest), np.array(highest)


def _approach_speed(distance: float, fastest: float, acceleration: float, jerk: float) -> float:
    """The highest speed towards its limit from which a joint with `distance` rad left can stop; negative beyond it."""
    beside = min(max(RETURN_S * distance, -fastest), fastest)
    return min(NEAR_LIMITS * stoppable(distance, acceleration, jerk), beside)


def _rate(off: float, braking: float) -> float:
    """The decay rate in 1/s of an error that is removed at constant braking."""
    return math.sqrt(2 * braking / max(off, TINY))

"""Closed-form inverse kinematics of an upright arm with parallel shoulder and elbow and a spherical wrist."""

import math
from dataclasses import dataclass

import numpy as np

from common.errors import ModelError
from common.geometry import Array
from remote_site.kinematics.config import BranchConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.kinematics.upright_arm import (
    RIGID,
    TURN,
    ArmAngles,
    Branch,
    Matrix,
    Point,
    UprightArm,
    WristTarget,
    in_forearm,
    pitch_and_twist,
)
from remote_site.reasons import Code, Reason, reason

WRIST_ZONE = 0.35  # rad of joint 5: nearer to straight, joint 4 is damped
WRIST_RATE = 60.0  # 1/s: how fast joint 4 goes to its goal at the border of that zone
ROLL_SPEED = 0.8  # of joint 4's own speed, for its target: the joint must be quicker, or the tool leaves its place
UNWIND = 0.5  # per rad: how much joint 4 in that zone prefers the goal nearer to its middle
LOST_MOST = 0.8  # rad of orientation that joints 4 and 6 may lose at their limits
SAMPLE_S = 1 / 30
BRANCH_CHANGE = 1.0  # rad: a solution in another branch is taken only if no joint moves further
PASSES = 20  # most iterations of `_compensated`
SETTLED = 1e-8  # m: when they have converged
ROUNDING = 1e-9  # rad: what it may put a joint beyond its limit
SIDES = {"keep": 0, "front": 1, "back": -1, "forward": 1, "backward": -1}
BRANCHES = 8
TRIED = 16  # postures at which the closed form is compared with the model
KEEP = BranchConfig()


@dataclass(frozen=True, slots=True)
class Solution:
    """Joint positions (6,) in rad that reach the target, and their branch.

    The position of the tool is always reached, but for a millimetre where `held` is set; `lost_rad` of its orientation
    is not, while joint 4 is damped or too slow, or joint 4 or 6 at its limit.
    """

    q: Array
    branch: Branch
    held: bool = False
    lost_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class Unreachable:
    """There is no acceptable solution, and why."""

    reason: Reason


class SphericalWristInverse:
    """Inverse kinematics within limits, in a chosen branch or the arm's; ModelError if the arm is of another kind."""

    def __init__(self, model: ArmModel, limits: JointLimits, branch: BranchConfig = KEEP) -> None:
        self._model = model
        self._chosen = Branch(SIDES[branch.shoulder], SIDES[branch.elbow], SIDES[branch.wrist])
        self._arm = UprightArm.from_model(model)
        self._roll_speed = ROLL_SPEED * float(limits.velocity[3])
        self._limits = limits
        self._bounds = list(zip(limits.lower.tolist(), limits.upper.tolist(), strict=True))
        elbow = min(max(abs(limits.lower[2]), abs(limits.upper[2])), math.pi)
        upper_arm, forearm = self._arm.upper_arm, self._arm.forearm
        self._least = math.sqrt(upper_arm**2 + forearm**2 + 2 * upper_arm * forearm * math.cos(elbow))

    def verify(self) -> None:
        """Compare the closed form with the model at postures all over the joints' range; ModelError if it differs."""
        spread = np.outer(np.arange(1, TRIED + 1), np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0])) % 1.0
        for q in self._limits.lower + spread * (self._limits.upper - self._limits.lower):
            pose = self._model.forward(q)
            found = self.solutions(pose)
            off = [float(np.abs(self._model.forward(solution.q) - pose).max()) for solution in found]
            if len(found) != BRANCHES or max(off) > RIGID:
                raise ModelError("the closed form does not lead back to poses of this arm")

    def check_branch(self, q: Array) -> None:
        """ModelError if the arm at `q` (6,) rad is in another branch than the chosen one."""
        current = self._arm.branch_of(tuple(q.tolist()))
        for name, wanted, here in zip(Branch._fields, self._chosen, current, strict=True):
            if wanted not in (0, here):
                raise ModelError(f"robot.stance.{name} is not that of robot.start_deg; change one of them")

    def solutions(self, base_T_tool: Array) -> list[Solution]:
        """All eight solutions in (-pi, pi], without regard to limits; empty out of reach or if not a rigid pose."""
        target = self._arm.target(base_T_tool)
        if target is None:
            return []
        found = []
        for arm in self._arm.arms_to(self._arm.centre(target), None):
            m = in_forearm(target.rotation, arm.angles)
            roll = math.atan2(m[1][2], m[0][2])
            for angle in (roll, roll + math.pi):
                angles = (*arm.angles, angle, *pitch_and_twist(m, angle))
                branch = Branch(arm.shoulder, arm.elbow, 1 if angles[4] >= 0 else -1)
                found.append(Solution(np.array(self._arm.joints(angles)), branch))
        return found

    def nearest(
        self, base_T_tool: Array, q_current: Array, elapsed_s: float = SAMPLE_S, speed: float = 1.0
    ) -> Solution | Unreachable:
        """The solution within limits nearest to `q_current` (6,), the one before, each joint unwrapped.

        It keeps the branch, unless another one is near, as when a singularity is crossed. Joint 4 goes to the nearer of
        its two goals, no faster than it can in `elapsed_s` at the fraction `speed` of its own, and the slower the
        straighter the wrist is, where it would spin for nothing; meanwhile the tool keeps its position and loses some
        orientation. Above the shoulder joint 1 keeps its angle.
        """
        target = self._arm.target(base_T_tool)
        current: tuple[float, ...] = tuple(q_current.tolist())
        if target is None or not math.isfinite(sum(current)):
            return Unreachable(reason(Code.NOT_A_POSE))
        best: Solution | None = None
        least, refusal = math.inf, None
        arms = [
            (_apart(self._arm.unwrapped(arm.angles, current), current), arm)
            for arm in self._arm.arms_to(self._arm.centre(target), current[0])
            if self._chosen.shoulder in (0, arm.shoulder) and self._chosen.elbow in (0, arm.elbow)
        ]
        for arm_cost, arm in sorted(arms):
            if arm_cost >= least:
                break
            found = self._completed(target, arm, current, elapsed_s, speed)
            if isinstance(found, Solution):
                cost = _apart(found.q.tolist(), current)
                best, least = (found, cost) if cost < least else (best, least)
            else:
                refusal = refusal or found
        return best or Unreachable(self._out_of_reach(target, refusal))

    def _completed(
        self, target: WristTarget, arm: ArmAngles, current: tuple[float, ...], elapsed_s: float, speed: float
    ) -> Solution | Reason:
        """Joints 4 to 6 for an arm; while joint 4 is not at its goal, the arm compensates so that the tool is."""
        m = in_forearm(target.rotation, arm.angles)
        roll, lags = self._roll(m, current, elapsed_s, speed)
        pitch, twist, over = self._limited(pitch_and_twist(m, roll), current)
        lost = 0.0
        if lags or over:
            compensated = self._compensated(target, arm, roll, current)
            if compensated is None:
                return self._out_of_reach(target, self._at_limit(3, current[3]))
            arm = compensated
            m = in_forearm(target.rotation, arm.angles)
            pitch, twist, over = self._limited(pitch_and_twist(m, roll), current)
            beside = math.asin(min(abs(math.cos(roll) * m[1][2] - math.sin(roll) * m[0][2]), 1.0))
            lost = math.hypot(beside, over)
        q = self._arm.unwrapped((*arm.angles, roll, pitch, twist), current)
        branch = Branch(arm.shoulder, arm.elbow, 1 if pitch >= 0 else -1)
        return self._refusal(q, current, branch, lost) or Solution(np.array(q), branch, arm.held, lost)

    def _compensated(
        self, target: WristTarget, arm: ArmAngles, roll: float, current: tuple[float, ...]
    ) -> ArmAngles | None:
        """The arm that brings the tool to its position though joint 4 is at `roll`; None if there is none.

        A fixed point of the wrist centre, found by Anderson's acceleration with one step of memory.
        """
        centre = self._arm.centre(target)
        last_off, last_next = (0.0, 0.0, 0.0), centre
        for k in range(PASSES):
            m = in_forearm(target.rotation, arm.angles)
            pitch, twist, _ = self._limited(pitch_and_twist(m, roll), current)
            wanted = self._arm.centre_at(target, (*arm.angles, roll, pitch, twist))
            off = _minus(wanted, centre)
            if _dot(off, off) < SETTLED**2:
                return arm
            change = _minus(off, last_off)
            mixed = _dot(off, change) / _dot(change, change) if k else 0.0
            step = _minus(wanted, last_next)
            last_off, last_next = off, wanted
            centre = (wanted[0] - mixed * step[0], wanted[1] - mixed * step[1], wanted[2] - mixed * step[2])
            next_arm = self._arm.arm_to(centre, arm.shoulder, arm.elbow, current[0])
            if next_arm is None:
                return None
            arm = next_arm
        return None

    def _limited(self, pitch_and_twist: tuple[float, float], current: tuple[float, ...]) -> tuple[float, float, float]:
        """Joints 5 and 6, the latter stopped at its limit, and how far beyond it should be."""
        pitch, twist = pitch_and_twist
        sign, (lower, upper) = self._arm.signs[5], self._bounds[5]
        q = sign * twist + TURN * round((current[5] - sign * twist) / TURN)
        inside = min(max(q, lower), upper)
        return pitch, sign * inside, abs(q - inside)

    def _roll(self, m: Matrix, current: tuple[float, ...], elapsed_s: float, speed: float) -> tuple[float, bool]:
        """Joint 4's angle for now, and whether its goal is elsewhere."""
        sign, (lower, upper) = self._arm.signs[3], self._bounds[3]
        here = sign * current[3]
        bend = math.hypot(m[0][2], m[1][2])
        turn = math.remainder(math.atan2(m[1][2], m[0][2]) - here, math.pi)
        other = turn - math.copysign(math.pi, turn)
        if bend < WRIST_ZONE and abs(other) + UNWIND * abs(here + other) < abs(turn) + UNWIND * abs(here + turn):
            turn = other
        step = turn * _damped_fraction(bend, elapsed_s) if m[2][2] > 0 else turn
        most = speed * self._roll_speed * elapsed_s
        step = min(max(step, -most), most)
        roll = sign * min(max(sign * (here + step), lower), upper)
        return roll, roll != here + turn

    def _refusal(self, q: list[float], current: tuple[float, ...], branch: Branch, lost: float) -> Reason | None:
        for i, (value, (lower, upper)) in enumerate(zip(q, self._bounds, strict=True)):
            at_limit = i in (3, 5) and value in (lower, upper)
            if not lower - ROUNDING <= value <= upper + ROUNDING or (at_limit and lost > LOST_MOST):
                return self._at_limit(i, value)
        if self._chosen.wrist not in (0, branch.wrist):
            return self._other_branch(4, abs(q[4]))
        moves = [abs(a - b) for a, b in zip(q, current, strict=True)]
        move = max(moves)
        if move <= BRANCH_CHANGE or branch == self._arm.branch_of(current):
            return None
        return self._other_branch(moves.index(move), move)

    def _other_branch(self, joint: int, move_rad: float) -> Reason:
        return reason(Code.STANCE, joint=self._limits.names[joint], move_deg=math.degrees(move_rad))

    def _at_limit(self, joint: int, value: float) -> Reason:
        value_deg, lower_deg, upper_deg = (math.degrees(v) for v in (value, *self._bounds[joint]))
        name = self._limits.names[joint]
        return reason(Code.IK_LIMIT, joint=name, value_deg=value_deg, lower_deg=lower_deg, upper_deg=upper_deg)

    def _out_of_reach(self, target: WristTarget, refusal: Reason | None) -> Reason:
        """Say why there is no solution: the wrist's distance if that is it, else the nearest solution's refusal."""
        x, y, z = self._arm.centre(target)
        distance = math.hypot(x, y, z - self._arm.shoulder_height)
        if refusal is not None and distance >= self._least:
            return refusal
        most = self._arm.upper_arm + self._arm.forearm
        return reason(Code.OUT_OF_REACH, distance_mm=distance * 1e3, least_mm=self._least * 1e3, most_mm=most * 1e3)


def _damped_fraction(bend: float, elapsed_s: float) -> float:
    """The fraction of its turn that joint 4 makes in `elapsed_s`, when the wrist is bent by the sine `bend`."""
    if bend >= WRIST_ZONE:
        return 1.0
    return -math.expm1(-elapsed_s * WRIST_RATE * (bend / WRIST_ZONE) ** 2) if bend > 0.0 else 0.0


def _apart(q: list[float], current: tuple[float, ...]) -> float:
    """The squared distance in joint space, of as many joints as there are."""
    return sum((a - b) ** 2 for a, b in zip(q, current, strict=False))


def _minus(a: Point, b: Point) -> Point:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Point, b: Point) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]

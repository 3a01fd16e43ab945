"""Closed-form inverse kinematics of an upright arm with parallel shoulder and elbow and a spherical wrist."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from common.geometry import Array, inverse
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.kinematics.upright import UprightGeometry
from remote_site.safety.status import Code, Reason, reason

REACH = 1e-12  # of the cosine of the elbow: rounding at full stretch
WRIST_HOLD = 0.02  # rad of joint 5: nearer to straight, joint 4 keeps its place (at most as much orientation is lost)
SHOULDER_HOLD = 1e-3  # m from the axis of joint 1: nearer, joint 1 keeps its place (at most as much position is lost)
STANCE_CHANGE = 1.0  # rad: a solution in another stance is taken only if no joint moves further
RIGID = 1e-6  # how far a target's rotation may be from orthonormal
TURN = 2 * math.pi

Rows = list[list[float]]


class Stance(NamedTuple):
    """Which of the eight: shoulder to the front or back, elbow, wrist turned one way (+1) or the other (-1)."""

    shoulder: int
    elbow: int
    wrist: int


@dataclass(frozen=True, slots=True)
class Solution:
    """Joint positions (6,) in rad that reach the target, their stance, and whether a singularity held a joint."""

    q: Array
    stance: Stance
    held: bool


@dataclass(frozen=True, slots=True)
class Unreachable:
    """There is no acceptable solution, and why."""

    reason: Reason


class Arm(NamedTuple):
    """A solution for joints 1 to 3 in the canonical angles, positive about +z and +y."""

    angles: tuple[float, ...]
    shoulder: int
    elbow: int
    held: bool


class Branch(NamedTuple):
    """A solution for all joints in the canonical angles."""

    angles: tuple[float, ...]
    stance: Stance
    held: bool


class SphericalWristInverse:
    """Inverse kinematics within limits; ModelError if the arm is of another kind."""

    def __init__(self, model: ArmModel, limits: JointLimits) -> None:
        self._arm = UprightGeometry.from_model(model)
        self._tcp_T_wrist = inverse(self._arm.wrist_T_tcp)
        self._limits = limits
        self._bounds = list(zip(limits.lower.tolist(), limits.upper.tolist(), strict=True))
        elbow = min(max(abs(limits.lower[2]), abs(limits.upper[2])), math.pi)
        upper_arm, forearm = self._arm.upper_arm, self._arm.forearm
        self._least = math.sqrt(upper_arm**2 + forearm**2 + 2 * upper_arm * forearm * math.cos(elbow))

    def solutions(self, base_T_tool: Array) -> list[Solution]:
        """All eight solutions in (-pi, pi], without regard to limits; empty out of reach or if not a rigid pose."""
        wrist = self._wrist(base_T_tool)
        if wrist is None:
            return []
        return [
            Solution(np.array(self._joints(branch.angles)), branch.stance, branch.held)
            for arm in self._arms(wrist, None)
            for branch in self._branches(arm, wrist, None)
        ]

    def nearest(self, base_T_tool: Array, q_current: Array) -> Solution | Unreachable:
        """The solution within limits nearest to `q_current` (6,) in joint space, each joint unwrapped towards it.

        It keeps the stance, unless another one is near, as when a singularity is crossed. At the singularities of
        wrist and shoulder, joint 4 and joint 1 keep their place.
        """
        wrist = self._wrist(base_T_tool)
        current: tuple[float, ...] = tuple(q_current.tolist())
        if wrist is None or not math.isfinite(sum(current)):
            return Unreachable(reason(Code.NOT_A_POSE))
        best: tuple[float, Solution] | None = None
        worst: tuple[float, Reason] | None = None
        arms = [(_cost(self._unwrapped(arm.angles, current), current), arm) for arm in self._arms(wrist, current)]
        for arm_cost, arm in sorted(arms):
            if best is not None and arm_cost >= best[0]:
                break
            for branch in self._branches(arm, wrist, current):
                q = self._unwrapped(branch.angles, current)
                cost = _cost(q, current)
                refusal = self._refusal(q, current, branch.stance)
                if refusal is not None:
                    worst = (cost, refusal) if worst is None or cost < worst[0] else worst
                elif best is None or cost < best[0]:
                    best = cost, Solution(np.array(q), branch.stance, branch.held)
        if best is not None:
            return best[1]
        return Unreachable(self._out_of_reach(wrist, worst[1] if worst is not None else None))

    def _wrist(self, base_T_tool: Array) -> Rows | None:
        """The pose of the wrist centre as rows, or None if the target is not a finite rigid pose."""
        rows: Rows = (base_T_tool @ self._tcp_T_wrist).tolist()
        (a, b, c, x), (d, e, f, y), (g, h, i, z) = rows[:3]
        off = (
            abs(a * a + b * b + c * c - 1)
            + abs(d * d + e * e + f * f - 1)
            + abs(b * f - c * e - g)
            + abs(c * d - a * f - h)
            + abs(a * e - b * d - i)
        )
        return rows if off < RIGID and math.isfinite(x + y + z) else None

    def _arms(self, wrist: Rows, current: tuple[float, ...] | None) -> Iterator[Arm]:
        """Joints 1 to 3 that bring the wrist centre to its place."""
        (*_, x), (*_, y), (*_, z) = wrist[:3]
        arm, h = self._arm, z - self._arm.shoulder_height
        yaw, held = math.atan2(y, x), False
        if current is not None and math.hypot(x, y) < SHOULDER_HOLD:
            yaw, held = arm.signs[0] * current[0], True
        for shoulder, turn in ((1, yaw), (-1, yaw + math.pi)):
            r = math.cos(turn) * x + math.sin(turn) * y
            cosine = (r * r + h * h - arm.upper_arm**2 - arm.forearm**2) / (2 * arm.upper_arm * arm.forearm)
            if abs(cosine) > 1 + REACH:
                return
            bend = math.acos(min(max(cosine, -1.0), 1.0))
            inner = math.atan2(arm.forearm * math.sin(bend), arm.upper_arm + arm.forearm * math.cos(bend))
            for elbow in (1, -1):
                yield Arm((turn, math.atan2(r, h) - elbow * inner, elbow * bend), shoulder, elbow, held)

    def _branches(self, arm: Arm, wrist: Rows, current: tuple[float, ...] | None) -> Iterator[Branch]:
        """Joints 4 to 6 that turn the wrist as it shall be."""
        yaw, lean, bend = arm.angles
        m = _in_forearm(wrist, yaw, lean + bend)
        held = arm.held
        if current is not None and m[2][2] > 0 and math.hypot(m[0][2], m[1][2]) < WRIST_HOLD:
            rolls, held = [self._arm.signs[3] * current[3]], True
        else:
            roll = math.atan2(m[1][2], m[0][2])
            rolls = [roll, roll + math.pi]
        for roll in rolls:
            pitch, twist = _pitch_and_twist(m, roll)
            stance = Stance(arm.shoulder, arm.elbow, 1 if pitch >= 0 else -1)
            yield Branch((*arm.angles, roll, pitch, twist), stance, held)

    def _joints(self, angles: tuple[float, ...]) -> list[float]:
        return [sign * math.remainder(angle, TURN) for sign, angle in zip(self._arm.signs, angles, strict=True)]

    def _unwrapped(self, angles: tuple[float, ...], current: tuple[float, ...]) -> list[float]:
        """The joints by whole turns nearest to `current`; a joint at its limit never turns back all the way round."""
        return [
            sign * angle + TURN * round((here - sign * angle) / TURN)
            for sign, angle, here in zip(self._arm.signs, angles, current, strict=False)
        ]

    def _refusal(self, q: list[float], current: tuple[float, ...], stance: Stance) -> Reason | None:
        for i, (value, (lower, upper)) in enumerate(zip(q, self._bounds, strict=True)):
            if not lower <= value <= upper:
                place = {"value_deg": value, "lower_deg": lower, "upper_deg": upper}
                degrees = {key: math.degrees(v) for key, v in place.items()}
                return reason(Code.IK_LIMIT, joint=self._limits.names[i], **degrees)
        moves = [abs(a - b) for a, b in zip(q, current, strict=True)]
        move = max(moves)
        if move <= STANCE_CHANGE or stance == self._stance_of(current):
            return None
        return reason(Code.STANCE, joint=self._limits.names[moves.index(move)], move_deg=math.degrees(move))

    def _stance_of(self, current: tuple[float, ...]) -> Stance:
        _, lean, bend, _, pitch, _ = (s * q for s, q in zip(self._arm.signs, current, strict=True))
        r = self._arm.upper_arm * math.sin(lean) + self._arm.forearm * math.sin(lean + bend)
        return Stance(1 if r >= 0 else -1, 1 if bend >= 0 else -1, 1 if pitch >= 0 else -1)

    def _out_of_reach(self, wrist: Rows, refusal: Reason | None) -> Reason:
        """Why no solution will do: the wrist's distance if that is it, otherwise the nearest solution's refusal."""
        (*_, x), (*_, y), (*_, z) = wrist[:3]
        distance = math.hypot(x, y, z - self._arm.shoulder_height)
        if refusal is not None and distance >= self._least:
            return refusal
        most = self._arm.upper_arm + self._arm.forearm
        return reason(Code.OUT_OF_REACH, distance_mm=distance * 1e3, least_mm=self._least * 1e3, most_mm=most * 1e3)


def _cost(q: list[float], current: tuple[float, ...]) -> float:
    """The squared distance in joint space, of as many joints as there are."""
    return sum((a - b) ** 2 for a, b in zip(q, current, strict=False))


def _in_forearm(wrist: Rows, yaw: float, lean: float) -> Rows:
    """The rotation of the wrist as seen from the forearm: Ry(-lean) Rz(-yaw) R."""
    cy, sy, cl, sl = math.cos(yaw), math.sin(yaw), math.cos(lean), math.sin(lean)
    first, second, third = wrist[0][:3], wrist[1][:3], wrist[2][:3]
    ahead = [cy * a + sy * b for a, b in zip(first, second, strict=True)]
    return [
        [cl * a - sl * c for a, c in zip(ahead, third, strict=True)],
        [cy * b - sy * a for a, b in zip(first, second, strict=True)],
        [sl * a + cl * c for a, c in zip(ahead, third, strict=True)],
    ]


def _pitch_and_twist(m: Rows, roll: float) -> tuple[float, float]:
    """Joints 5 and 6 that best make up the rotation Rz(roll) Ry(pitch) Rz(twist), given the roll."""
    c, s = math.cos(roll), math.sin(roll)
    pitch = math.atan2(c * m[0][2] + s * m[1][2], m[2][2])
    cp, sp = math.cos(pitch), math.sin(pitch)
    xx = cp * (c * m[0][0] + s * m[1][0]) - sp * m[2][0]
    xy = cp * (c * m[0][1] + s * m[1][1]) - sp * m[2][1]
    yx, yy = c * m[1][0] - s * m[0][0], c * m[1][1] - s * m[0][1]
    return pitch, math.atan2(yx - xy, xx + yy)

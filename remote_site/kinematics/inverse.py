"""Closed-form inverse kinematics of an upright arm with parallel shoulder and elbow and a spherical wrist."""

import math
from collections.abc import Iterator

import numpy as np

from common.errors import ModelError
from common.geometry import Array, inverse
from remote_site.kinematics.config import StanceConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.kinematics.solution import Solution, Stance, Unreachable
from remote_site.kinematics.spherical import (
    TURN,
    ArmSolution,
    Matrix,
    Point,
    Target,
    apart,
    dot,
    in_forearm,
    minus,
    pitch_and_twist,
)
from remote_site.kinematics.upright import UprightGeometry
from remote_site.reasons import Code, Reason, reason

REACH = 1e-12  # of the cosine of the elbow: rounding at full stretch
WRIST_ZONE = 0.35  # rad of joint 5: nearer to straight, joint 4 is damped
WRIST_RATE = 60.0  # 1/s: how fast joint 4 goes to its place at the border of that zone
ROLL_SPEED = 1.5  # of joint 4's own speed: how far its target runs ahead of it
UNWIND = 0.5  # per rad: how much joint 4 in that zone prefers the place nearer to its middle
LOST_MOST = 0.8  # rad of orientation that joints 4 and 6 may lose at their limits
SAMPLE_S = 1 / 30
SHOULDER_HOLD = 1e-3  # m from the axis of joint 1: nearer, joint 1 keeps its place (at most as much position is lost)
STANCE_CHANGE = 1.0  # rad: a solution in another stance is taken only if no joint moves further
PASSES = 20  # of bringing the arm after a tool whose wrist is turned otherwise
SETTLED = 1e-8  # m: when that is done
ROUNDING = 1e-9  # rad: what it may put a joint beyond its limit
SIDES = {"keep": 0, "front": 1, "back": -1, "forward": 1, "backward": -1}
BRANCHES = 8
TRIED = 16  # postures at which the closed form is compared with the model
RIGID = 1e-6  # how far a target's rotation may be from orthonormal


KEEP = StanceConfig()


class SphericalWristInverse:
    """Inverse kinematics within limits, in a chosen stance or the arm's; ModelError if the arm is of another kind."""

    def __init__(self, model: ArmModel, limits: JointLimits, stance: StanceConfig = KEEP) -> None:
        self._model = model
        self._chosen = Stance(SIDES[stance.shoulder], SIDES[stance.elbow], SIDES[stance.wrist])
        self._arm = UprightGeometry.from_model(model)
        self._tcp_T_wrist = inverse(self._arm.wrist_T_tcp)
        self._offset = tuple(self._arm.wrist_T_tcp[:3, 3].tolist())
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

    def check_stance(self, q: Array) -> None:
        """ModelError if the arm at `q` (6,) rad is in another stance than the chosen one."""
        current = self._stance_of(tuple(q.tolist()))
        for name, wanted, here in zip(Stance._fields, self._chosen, current, strict=True):
            if wanted not in (0, here):
                raise ModelError(f"robot.stance.{name} is not that of robot.start_deg; change one of them")

    def solutions(self, base_T_tool: Array) -> list[Solution]:
        """All eight solutions in (-pi, pi], without regard to limits; empty out of reach or if not a rigid pose."""
        target = self._target(base_T_tool)
        if target is None:
            return []
        found = []
        for arm in self._arms(self._centre(target), None):
            m = in_forearm(target.rotation, arm.angles)
            roll = math.atan2(m[1][2], m[0][2])
            for angle in (roll, roll + math.pi):
                angles = (*arm.angles, angle, *pitch_and_twist(m, angle))
                stance = Stance(arm.shoulder, arm.elbow, 1 if angles[4] >= 0 else -1)
                found.append(Solution(np.array(self._joints(angles)), stance))
        return found

    def nearest(self, base_T_tool: Array, q_current: Array, elapsed_s: float = SAMPLE_S) -> Solution | Unreachable:
        """The solution within limits nearest to `q_current` (6,), the posture last commanded, each joint unwrapped.

        It keeps the stance, unless another one is near, as when a singularity is crossed. Joint 4 goes to the nearer of
        its two places, no faster than it can in `elapsed_s`, and the slower the straighter the wrist is, where it would
        spin for nothing; meanwhile the tool keeps its position and loses some orientation. Above the shoulder joint 1
        keeps its place.
        """
        target = self._target(base_T_tool)
        current: tuple[float, ...] = tuple(q_current.tolist())
        if target is None or not math.isfinite(sum(current)):
            return Unreachable(reason(Code.NOT_A_POSE))
        best: tuple[float, Solution] | None = None
        worst: tuple[float, Reason] | None = None
        arms = [
            (apart(self._unwrapped(arm.angles, current), current), arm)
            for arm in self._arms(self._centre(target), current)
            if self._chosen.shoulder in (0, arm.shoulder) and self._chosen.elbow in (0, arm.elbow)
        ]
        for arm_cost, arm in sorted(arms):
            if best is not None and arm_cost >= best[0]:
                break
            found = self._placed(target, arm, current, elapsed_s)
            if isinstance(found, Solution):
                way = apart(found.q.tolist(), current)
                best = (way, found) if best is None or way < best[0] else best
            elif worst is None:
                worst = arm_cost, found
        if best is not None:
            return best[1]
        return Unreachable(self._out_of_reach(target, worst[1] if worst is not None else None))

    def _target(self, base_T_tool: Array) -> Target | None:
        """The target of tool and wrist, or None if it is not a finite rigid pose."""
        (a, b, c, _), (d, e, f, _), (g, h, i, _), _ = (base_T_tool @ self._tcp_T_wrist).tolist()
        off = (
            abs(a * a + b * b + c * c - 1)
            + abs(d * d + e * e + f * f - 1)
            + abs(b * f - c * e - g)
            + abs(c * d - a * f - h)
            + abs(a * e - b * d - i)
        )
        x, y, z = base_T_tool[:3, 3].tolist()
        if not (off < RIGID and math.isfinite(x + y + z)):
            return None
        return Target((x, y, z), ((a, b, c), (d, e, f), (g, h, i)))

    def _centre(self, target: Target) -> Point:
        """The wrist centre, when the wrist is turned as it shall be."""
        (x, y, z), ((a, b, c), (d, e, f), (g, h, i)) = target
        u, v, w = self._offset
        return x - a * u - b * v - c * w, y - d * u - e * v - f * w, z - g * u - h * v - i * w

    def _arms(self, centre: Point, current: tuple[float, ...] | None) -> Iterator[ArmSolution]:
        """Joints 1 to 3 that bring the wrist centre to its place."""
        for shoulder in (1, -1):
            for elbow in (1, -1):
                arm = self._arm_with(centre, shoulder, elbow, current)
                if arm is None:
                    return
                yield arm

    def _arm_with(
        self, centre: Point, shoulder: int, elbow: int, current: tuple[float, ...] | None
    ) -> ArmSolution | None:
        """The arm of this shoulder and elbow, or None out of reach."""
        x, y, z = centre
        arm, h = self._arm, z - self._arm.shoulder_height
        turn, held = math.atan2(y, x), False
        if current is not None and math.hypot(x, y) < SHOULDER_HOLD:
            turn, held = arm.signs[0] * current[0], True
        if shoulder < 0:
            turn += math.pi
        r = math.cos(turn) * x + math.sin(turn) * y
        cosine = (r * r + h * h - arm.upper_arm**2 - arm.forearm**2) / (2 * arm.upper_arm * arm.forearm)
        if abs(cosine) > 1 + REACH:
            return None
        cosine = min(max(cosine, -1.0), 1.0)
        sine = math.sqrt(1.0 - cosine * cosine)
        inner = math.atan2(arm.forearm * sine, arm.upper_arm + arm.forearm * cosine)
        return ArmSolution((turn, math.atan2(r, h) - elbow * inner, elbow * math.acos(cosine)), shoulder, elbow, held)

    def _placed(
        self, target: Target, arm: ArmSolution, current: tuple[float, ...], elapsed_s: float
    ) -> Solution | Reason:
        """Joints 4 to 6 for an arm; while joint 4 is not at its place, the arm moves so that the tool is."""
        m = in_forearm(target.rotation, arm.angles)
        roll, rest = self._roll(m, current, elapsed_s)
        pitch, twist, over = self._limited(pitch_and_twist(m, roll), current)
        lost = 0.0
        if rest or over:
            moved = self._moved(target, arm, roll, current)
            if moved is None:
                return self._out_of_reach(target, self._at_limit(3, current[3]))
            arm = moved
            m = in_forearm(target.rotation, arm.angles)
            pitch, twist, over = self._limited(pitch_and_twist(m, roll), current)
            beside = math.asin(min(abs(math.cos(roll) * m[1][2] - math.sin(roll) * m[0][2]), 1.0))
            lost = math.hypot(beside, over)
        q = self._unwrapped((*arm.angles, roll, pitch, twist), current)
        stance = Stance(arm.shoulder, arm.elbow, 1 if pitch >= 0 else -1)
        refusal = self._refusal(q, current, stance, lost)
        return refusal if refusal is not None else Solution(np.array(q), stance, arm.held, lost)

    def _moved(self, target: Target, arm: ArmSolution, roll: float, current: tuple[float, ...]) -> ArmSolution | None:
        """The arm that brings the tool to its position though joint 4 is at `roll`; None if there is none.

        A fixed point of the wrist centre, found by Anderson's acceleration with one step of memory.
        """
        centre = self._centre(target)
        last_off, last_next = (0.0, 0.0, 0.0), centre
        for k in range(PASSES):
            m = in_forearm(target.rotation, arm.angles)
            pitch, twist, _ = self._limited(pitch_and_twist(m, roll), current)
            wanted = self._centre_of(target, (*arm.angles, roll, pitch, twist))
            off = minus(wanted, centre)
            if dot(off, off) < SETTLED**2:
                return arm
            change = minus(off, last_off)
            share = dot(off, change) / dot(change, change) if k else 0.0
            step = minus(wanted, last_next)
            last_off, last_next = off, wanted
            centre = (wanted[0] - share * step[0], wanted[1] - share * step[1], wanted[2] - share * step[2])
            next_arm = self._arm_with(centre, arm.shoulder, arm.elbow, current)
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

    def _roll(self, m: Matrix, current: tuple[float, ...], elapsed_s: float) -> tuple[float, bool]:
        """Joint 4's angle for now, and whether its place is elsewhere."""
        sign, (lower, upper) = self._arm.signs[3], self._bounds[3]
        here = sign * current[3]
        bend = math.hypot(m[0][2], m[1][2])
        way = math.remainder(math.atan2(m[1][2], m[0][2]) - here, math.pi)
        other = way - math.copysign(math.pi, way)
        if bend < WRIST_ZONE and abs(other) + UNWIND * abs(here + other) < abs(way) + UNWIND * abs(here + way):
            way = other
        step = way * _share(bend, elapsed_s) if m[2][2] > 0 else way
        most = self._roll_speed * elapsed_s
        step = min(max(step, -most), most)
        roll = sign * min(max(sign * (here + step), lower), upper)
        return roll, roll != here + way

    def _centre_of(self, target: Target, angles: tuple[float, ...]) -> Point:
        """The wrist centre that brings the tool to its position, when the joints turn it as they do."""
        yaw, lean, bend, roll, pitch, twist = angles
        x, y, z = self._offset
        c, s = math.cos(twist), math.sin(twist)
        x, y = c * x - s * y, s * x + c * y
        c, s = math.cos(pitch), math.sin(pitch)
        x, z = c * x + s * z, c * z - s * x
        c, s = math.cos(roll), math.sin(roll)
        x, y = c * x - s * y, s * x + c * y
        c, s = math.cos(lean + bend), math.sin(lean + bend)
        x, z = c * x + s * z, c * z - s * x
        c, s = math.cos(yaw), math.sin(yaw)
        x, y = c * x - s * y, s * x + c * y
        return target.tcp[0] - x, target.tcp[1] - y, target.tcp[2] - z

    def _joints(self, angles: tuple[float, ...]) -> list[float]:
        return [sign * math.remainder(angle, TURN) for sign, angle in zip(self._arm.signs, angles, strict=True)]

    def _unwrapped(self, angles: tuple[float, ...], current: tuple[float, ...]) -> list[float]:
        """The joints by whole turns nearest to `current`; a joint at its limit never turns back all the way round."""
        return [
            sign * angle + TURN * round((here - sign * angle) / TURN)
            for sign, angle, here in zip(self._arm.signs, angles, current, strict=False)
        ]

    def _refusal(self, q: list[float], current: tuple[float, ...], stance: Stance, lost: float) -> Reason | None:
        for i, (value, (lower, upper)) in enumerate(zip(q, self._bounds, strict=True)):
            at_limit = i in (3, 5) and value in (lower, upper)
            if not lower - ROUNDING <= value <= upper + ROUNDING or (at_limit and lost > LOST_MOST):
                return self._at_limit(i, value)
        if self._chosen.wrist not in (0, stance.wrist):
            return reason(Code.STANCE, joint=self._limits.names[4], move_deg=math.degrees(abs(q[4])))
        moves = [abs(a - b) for a, b in zip(q, current, strict=True)]
        move = max(moves)
        if move <= STANCE_CHANGE or stance == self._stance_of(current):
            return None
        return reason(Code.STANCE, joint=self._limits.names[moves.index(move)], move_deg=math.degrees(move))

    def _at_limit(self, joint: int, value: float) -> Reason:
        lower, upper = self._bounds[joint]
        place = {"value_deg": value, "lower_deg": lower, "upper_deg": upper}
        degrees = {key: math.degrees(v) for key, v in place.items()}
        return reason(Code.IK_LIMIT, joint=self._limits.names[joint], **degrees)

    def _stance_of(self, current: tuple[float, ...]) -> Stance:
        _, lean, bend, _, pitch, _ = (s * q for s, q in zip(self._arm.signs, current, strict=True))
        r = self._arm.upper_arm * math.sin(lean) + self._arm.forearm * math.sin(lean + bend)
        return Stance(1 if r >= 0 else -1, 1 if bend >= 0 else -1, 1 if pitch >= 0 else -1)

    def _out_of_reach(self, target: Target, refusal: Reason | None) -> Reason:
        """Why no solution will do: the wrist's distance if that is it, otherwise the nearest solution's refusal."""
        x, y, z = self._centre(target)
        distance = math.hypot(x, y, z - self._arm.shoulder_height)
        if refusal is not None and distance >= self._least:
            return refusal
        most = self._arm.upper_arm + self._arm.forearm
        return reason(Code.OUT_OF_REACH, distance_mm=distance * 1e3, least_mm=self._least * 1e3, most_mm=most * 1e3)


def _share(bend: float, elapsed_s: float) -> float:
    """How much of its way joint 4 goes in `elapsed_s`, when the wrist is bent by the sine `bend`."""
    if bend >= WRIST_ZONE:
        return 1.0
    return -math.expm1(-elapsed_s * WRIST_RATE * (bend / WRIST_ZONE) ** 2) if bend > 0.0 else 0.0

"""An upright arm with parallel shoulder and elbow and a spherical wrist, in canonical angles, positive about +z and +y.

Its lengths are read from a model and verified. Scalars instead of arrays: for so few numbers NumPy would be slower.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np
import pinocchio as pin

from common.errors import ModelError
from common.geometry import Array, inverse, transform
from remote_site.kinematics.model import ArmModel

Point = tuple[float, float, float]
Matrix = tuple[Point, Point, Point]
TURN = 2 * math.pi
EXACT = 1e-6  # m, and of unit axes
REACH = 1e-12  # of the cosine of the elbow: rounding at full stretch
RIGID = 1e-6  # how far a target's rotation may be from orthonormal
SHOULDER_HOLD = 1e-3  # m from the axis of joint 1: nearer, joint 1 keeps its angle (at most as much position is lost)
PATTERN = "zyyzyz"  # the axis of each joint at the zero posture, in the base frame
CURE = "the closed form needs axes z y y z y z that meet the base's z axis at the zero posture"


class Branch(NamedTuple):
    """One of the eight IK configurations: shoulder to the front or back, elbow and wrist bent one way (+1) or the
    other (-1).
    """

    shoulder: int
    elbow: int
    wrist: int


class WristTarget(NamedTuple):
    """The wanted position of the tool centre point and orientation of the wrist, in the base frame."""

    tcp: Point
    rotation: Matrix


class ArmAngles(NamedTuple):
    """Canonical angles of joints 1 to 3 in rad, and their branch; `held` if joint 1 keeps its angle."""

    angles: Point
    shoulder: int
    elbow: int
    held: bool


@dataclass(frozen=True, slots=True)
class UprightArm:
    """Lengths in m; `signs` turn joint positions into canonical angles; tool centre point and wrist (4 x 4).

    At the zero posture the wrist frame has the axes of the base and its origin in the wrist centre.
    """

    shoulder_height: float
    upper_arm: float
    forearm: float
    signs: tuple[float, ...]
    tcp_T_wrist: Array
    tcp_in_wrist: Point

    @classmethod
    def from_model(cls, model: ArmModel) -> Self:
        """Read and verify the geometry; ModelError states where the arm is of another kind."""
        if len(model.joint_names) != len(PATTERN):
            raise ModelError(f"the arm has {len(model.joint_names)} joints; {CURE}")
        data = model.pin_model.createData()
        jacobian = pin.computeJointJacobians(model.pin_model, data, np.zeros(model.pin_model.nq))
        origins = np.array([data.oMi[i].translation for i in range(1, model.pin_model.njoints)])  # (n, 3), in the base
        axes = np.array(jacobian[3:].T)
        signs = tuple(_sign(name, axes[i], PATTERN[i]) for i, name in enumerate(model.joint_names))
        for i, name in enumerate(model.joint_names):
            beside = origins[i, :2] if PATTERN[i] == "z" else origins[i, :1]
            if np.abs(beside).max() > EXACT:
                raise ModelError(f"{name} lies beside the base's z axis; {CURE}")
        shoulder, elbow, wrist = origins[1, 2], origins[2, 2], origins[4, 2]
        if not shoulder < elbow < wrist:
            raise ModelError(f"shoulder, elbow and wrist are not above each other; {CURE}")
        base_T_wrist = transform(np.eye(3), np.array([0.0, 0.0, wrist]))
        wrist_T_tcp = inverse(base_T_wrist) @ model.forward(np.zeros(len(PATTERN)))
        lengths = float(shoulder), float(elbow - shoulder), float(wrist - elbow)
        return cls(*lengths, signs, inverse(wrist_T_tcp), tuple(wrist_T_tcp[:3, 3].tolist()))

    def target(self, base_T_tool: Array) -> WristTarget | None:
        """The target of tool and wrist for a pose (4 x 4), or None if it is not a finite rigid one."""
        (a, b, c, _), (d, e, f, _), (g, h, i, _), _ = (base_T_tool @ self.tcp_T_wrist).tolist()
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
        return WristTarget((x, y, z), ((a, b, c), (d, e, f), (g, h, i)))

    def centre(self, target: WristTarget) -> Point:
        """The wrist centre if the wrist has the target's orientation."""
        (x, y, z), ((a, b, c), (d, e, f), (g, h, i)) = target
        u, v, w = self.tcp_in_wrist
        return x - a * u - b * v - c * w, y - d * u - e * v - f * w, z - g * u - h * v - i * w

    def centre_at(self, target: WristTarget, angles: tuple[float, ...]) -> Point:
        """The wrist centre that brings the tool centre point to its position if the six angles orient the wrist."""
        yaw, lean, bend, roll, pitch, twist = angles
        x, y, z = self.tcp_in_wrist
        x, y = _turned(x, y, twist)
        z, x = _turned(z, x, pitch)
        x, y = _turned(x, y, roll)
        z, x = _turned(z, x, lean + bend)
        x, y = _turned(x, y, yaw)
        return target.tcp[0] - x, target.tcp[1] - y, target.tcp[2] - z

    def arm_to(self, centre: Point, shoulder: int, elbow: int, joint_1: float | None) -> ArmAngles | None:
        """Joints 1 to 3 that bring the wrist centre there in a branch, or None out of reach.

        Above the shoulder joint 1 keeps the position `joint_1` in rad, if one is given.
        """
        x, y, z = centre
        h = z - self.shoulder_height
        yaw, held = math.atan2(y, x), False
        if joint_1 is not None and math.hypot(x, y) < SHOULDER_HOLD:
            yaw, held = self.signs[0] * joint_1, True
        if shoulder < 0:
            yaw += math.pi
        r = math.cos(yaw) * x + math.sin(yaw) * y
        cosine = (r * r + h * h - self.upper_arm**2 - self.forearm**2) / (2 * self.upper_arm * self.forearm)
        if abs(cosine) > 1 + REACH:
            return None
        cosine = min(max(cosine, -1.0), 1.0)
        sine = math.sqrt(1.0 - cosine * cosine)
        inner = math.atan2(self.forearm * sine, self.upper_arm + self.forearm * cosine)
        return ArmAngles((yaw, math.atan2(r, h) - elbow * inner, elbow * math.acos(cosine)), shoulder, elbow, held)

    def arms_to(self, centre: Point, joint_1: float | None) -> list[ArmAngles]:
        """The same in all four branches of shoulder and elbow; empty out of reach."""
        arms = [self.arm_to(centre, shoulder, elbow, joint_1) for shoulder in (1, -1) for elbow in (1, -1)]
        return [arm for arm in arms if arm is not None]

    def branch_of(self, q: tuple[float, ...]) -> Branch:
        """The branch of joint positions (6,) in rad."""
        _, lean, bend, _, pitch, _ = (s * value for s, value in zip(self.signs, q, strict=True))
        r = self.upper_arm * math.sin(lean) + self.forearm * math.sin(lean + bend)
        return Branch(1 if r >= 0 else -1, 1 if bend >= 0 else -1, 1 if pitch >= 0 else -1)

    def joints(self, angles: tuple[float, ...]) -> list[float]:
        """Joint positions in (-pi, pi] of canonical angles."""
        return [sign * math.remainder(angle, TURN) for sign, angle in zip(self.signs, angles, strict=True)]

    def unwrapped(self, angles: tuple[float, ...], current: tuple[float, ...]) -> list[float]:
        """Joint positions by whole turns nearest to `current`: a joint at its limit never turns back all the way."""
        return [
            sign * angle + TURN * round((here - sign * angle) / TURN)
            for sign, angle, here in zip(self.signs, angles, current, strict=False)
        ]


def in_forearm(rotation: Matrix, arm_angles: Point) -> Matrix:
    """A rotation in the base frame as seen from the forearm: Ry(-lean) Rz(-yaw) R."""
    yaw, lean = arm_angles[0], arm_angles[1] + arm_angles[2]
    cy, sy, cl, sl = math.cos(yaw), math.sin(yaw), math.cos(lean), math.sin(lean)
    (a, b, c), (d, e, f), (g, h, i) = rotation
    u, v, w = cy * a + sy * d, cy * b + sy * e, cy * c + sy * f
    return (
        (cl * u - sl * g, cl * v - sl * h, cl * w - sl * i),
        (cy * d - sy * a, cy * e - sy * b, cy * f - sy * c),
        (sl * u + cl * g, sl * v + cl * h, sl * w + cl * i),
    )


def pitch_and_twist(m: Matrix, roll: float) -> tuple[float, float]:
    """Joints 5 and 6 that best make up the rotation Rz(roll) Ry(pitch) Rz(twist), given the roll."""
    c, s = math.cos(roll), math.sin(roll)
    (mxx, mxy, mxz), (myx, myy, myz), (mzx, mzy, mzz) = m
    pitch = math.atan2(c * mxz + s * myz, mzz)
    cp, sp = math.cos(pitch), math.sin(pitch)
    xx = cp * (c * mxx + s * myx) - sp * mzx
    xy = cp * (c * mxy + s * myy) - sp * mzy
    yx, yy = c * myx - s * mxx, c * myy - s * mxy
    return pitch, math.atan2(yx - xy, xx + yy)


def _turned(x: float, y: float, angle: float) -> tuple[float, float]:
    c, s = math.cos(angle), math.sin(angle)
    return c * x - s * y, s * x + c * y


def _sign(name: str, axis: Array, letter: str) -> float:
    along = axis["xyz".index(letter)]
    if abs(abs(along) - 1) > EXACT:
        raise ModelError(f"{name} does not turn about the base's {letter} axis at the zero posture; {CURE}")
    return 1.0 if along > 0 else -1.0

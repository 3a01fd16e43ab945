"""Relative motion: from the hand's motion since its origin to the tool's target since its own."""

import math

import numpy as np

from common.errors import ConfigError
from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from remote_site.config import LocksConfig, MappingConfig

PROPER = 1e-6


class Mapping:
    """Moves the tool as the hand has moved since `engage`, in the robot's world axes (thesis section 4.2).

    While the hand shows no orientation (thumb hidden, hand open) the tool keeps its own; when the orientation is back,
    the hand's rotation counts from there, so the tool never swings.
    """

    def __init__(self, config: MappingConfig) -> None:
        self._base_R_operator = _proper_rotation(config)
        self._scale = config.scale
        self._moving = np.array([not lock for lock in (config.locks.x, config.locks.y, config.locks.z)], dtype=float)
        self._locks = config.locks
        self._wrist_origin = np.zeros(3)
        self._tool_origin = np.eye(4)
        self._hand_reference: Array | None = None
        self._rotation_reference = np.eye(3)
        self._rotation = np.eye(3)

    def engage(self, wrist_in_operator: Array, operator_R_hand: Array | None, base_T_tool: Array) -> None:
        """Capture both origins: from here the target is `base_T_tool` plus the hand's motion."""
        self._wrist_origin = wrist_in_operator.copy()
        self._tool_origin = base_T_tool.copy()
        self._hand_reference = operator_R_hand
        self._rotation_reference = self._rotation = np.eye(3)

    def target(self, wrist_in_operator: Array, operator_R_hand: Array | None) -> Array:
        """The tool's target `base_T_tool` (4 x 4) for a wrist (3,) in m and the hand's orientation, if it shows one."""
        moved = self._base_R_operator @ (wrist_in_operator - self._wrist_origin)
        self._turn(operator_R_hand)
        origin = self._tool_origin[:3, :3]
        turned = origin @ _locked(origin.T @ self._rotation @ origin, self._locks)
        return transform(turned, self._tool_origin[:3, 3] + self._scale * self._moving * moved)

    def _turn(self, operator_R_hand: Array | None) -> None:
        """Bring `_rotation`, the tool's unlocked rotation in the base's axes since engagement, up to date."""
        if operator_R_hand is None:
            self._hand_reference = None
            return
        if self._hand_reference is None:
            self._hand_reference = operator_R_hand
            self._rotation_reference = self._rotation
        turned = self._base_R_operator @ operator_R_hand @ self._hand_reference.T @ self._base_R_operator.T
        self._rotation = turned @ self._rotation_reference


def thesis_angles(wrist: Array, index: Array, thumb: Array) -> tuple[float, float, float]:
    """The hand's angles α, β, γ in rad about Z, Y and X (thesis section 4.2, figure 4.5), for display alone.

    α and β are the directions of the line from the wrist to the middle between the tips, projected onto XY and XZ;
    γ is the direction of the line from the thumb's to the index finger's tip, projected onto YZ.
    """
    ahead = 0.5 * (index + thumb) - wrist
    across = index - thumb
    alpha = math.atan2(ahead[1], ahead[0])
    beta = math.atan2(ahead[2], ahead[0])
    gamma = math.atan2(across[2], across[1])
    return alpha, beta, gamma


def _locked(tool_R_turned: Array, locks: LocksConfig) -> Array:
    """A rotation in the tool's axes without its locked parts: roll is the twist about z, the swing has x and y."""
    if not (locks.roll or locks.pitch or locks.yaw):
        return tool_R_turned
    z = tool_R_turned[:, 2]
    swing = _swing_to(z)
    twist = swing.T @ tool_R_turned
    vector = vector_from_rotation(swing)
    swing = rotation_from_vector(vector * np.array([not locks.yaw, not locks.pitch, 1.0]))
    return swing if locks.roll else swing @ twist


def _swing_to(z: Array) -> Array:
    """The shortest rotation that takes the z axis to the unit vector `z`; about x when that is opposite."""
    sine = math.hypot(z[0], z[1])
    angle = math.atan2(sine, z[2])
    axis = np.array([-z[1], z[0], 0.0]) / sine if sine > PROPER else np.array([1.0, 0.0, 0.0])
    return rotation_from_vector(angle * axis)


def _proper_rotation(config: MappingConfig) -> Array:
    rotation = np.array(config.base_R_operator)
    finite = bool(np.isfinite(rotation).all())
    if not finite or np.abs(rotation @ rotation.T - np.eye(3)).max() > PROPER or np.linalg.det(rotation) < 0:
        raise ConfigError(
            "mapping.base_R_operator is not a proper rotation; its rows must be orthogonal unit vectors, "
            "and the third the cross product of the first two"
        )
    return rotation

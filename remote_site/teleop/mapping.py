"""From the hand's motion to the tool's target: relative to both origins, or incremental from sample to sample; pure."""

import math
from dataclasses import dataclass
from typing import Protocol, Self

import numpy as np

from common.errors import ConfigError
from common.geometry import Array, transform
from common.messages.base import Vector3
from common.messages.hand import Intent
from remote_site.teleop.config import LocksConfig, MappingConfig
from remote_site.teleop.rotation_mapping import RotationMapping

PROPER = 1e-6
NO_LOCKS = LocksConfig()


class AppliedLocks(Protocol):
    """Motions that the arm does not copy: along the base's axes, about the tool's at the last reference."""

    @property
    def x(self) -> bool: ...
    @property
    def y(self) -> bool: ...
    @property
    def z(self) -> bool: ...
    @property
    def roll(self) -> bool: ...
    @property
    def pitch(self) -> bool: ...
    @property
    def yaw(self) -> bool: ...


@dataclass(frozen=True, slots=True)
class Steering:
    """What the operator changes while working; the scales multiply the configured one, locks add to the configured.

    `clutch_count` rises by one whenever the operator takes a new reference, after having moved the hand freely.
    """

    clutch_count: int = 0
    scale: float = 1.0
    rotation_scale: float = 1.0
    locks: AppliedLocks = NO_LOCKS

    @classmethod
    def of(cls, intent: Intent) -> Self:
        """The settings in the operator's intent."""
        return cls(intent.clutch_count, intent.scale, intent.rotation_scale, intent.locks)


class Mapping:
    """Moves the tool as the hand has moved since its reference, in the robot's world axes (thesis section 4.2).

    While the hand shows no orientation (thumb hidden, hand open) the tool keeps its own; when the orientation is back,
    the hand's rotation counts from there, so the tool never swings. A change of the settings never moves the target.
    """

    def __init__(self, config: MappingConfig) -> None:
        self._base_R_operator = _proper_rotation(config)
        self._config = config
        self._rotation = RotationMapping(self._base_R_operator)
        self._apply(Steering())
        self.engage(np.zeros(3), None, np.eye(4))

    def engage(self, hand_in_operator: Array, operator_R_hand: Array | None, base_T_tool: Array) -> None:
        """Capture both origins: from here the target is `base_T_tool` plus the hand's motion."""
        self._offset = base_T_tool[:3, 3] - self._gain @ hand_in_operator
        self._rotation.engage(operator_R_hand, base_T_tool[:3, :3])

    def steer(
        self, steering: Steering, hand_in_operator: Array, operator_R_hand: Array | None, base_T_target: Array
    ) -> None:
        """Apply the operator's settings; a change captures both origins again, the tool's from the present target."""
        if steering != self._steering:
            self._apply(steering)
            self.engage(hand_in_operator, operator_R_hand, base_T_target)

    def target(self, hand_in_operator: Array, operator_R_hand: Array | None) -> Array:
        """The target `base_T_tool` (4 x 4) for the hand's position (3,) in m and orientation, None if it shows none."""
        return transform(self._rotation.target(operator_R_hand), self._offset + self._gain @ hand_in_operator)

    def read(self, base_T_tool: Array) -> None:
        """Take the tool's measured pose when a sample comes; a target relative to both origins ignores it."""

    def elbow(self, wrist_in_operator: Vector3 | Array | None, elbow_in_operator: Vector3 | None) -> Array | None:
        """The operator's elbow from the wrist (3,) in m in the base's axes, None while one of them is not seen."""
        if elbow_in_operator is None or wrist_in_operator is None:
            return None
        elbow: Array = self._base_R_operator @ (np.array(elbow_in_operator) - np.array(wrist_in_operator))
        return elbow

    def _apply(self, steering: Steering) -> None:
        """Set the gain (3 x 3) from the hand's displacement in the operator frame to the tool's in the base frame."""
        own, theirs = self._config.locks, steering.locks
        moving = np.array([not (own.x or theirs.x), not (own.y or theirs.y), not (own.z or theirs.z)], dtype=float)
        self._gain = (self._config.scale * steering.scale * moving)[:, None] * self._base_R_operator
        free = np.array(
            [not (own.yaw or theirs.yaw), not (own.pitch or theirs.pitch), not (own.roll or theirs.roll)], dtype=float
        )
        self._rotation.steer(free, steering.rotation_scale)
        self._steering = steering


class IncrementalMapping(Mapping):
    """The tool's present position and the hand's motion since the last sample (ROBONAUT report, section 3, steps 2-5).

    Samples carry the hand's position, the sum of all displacements, so a lost sample loses no motion. But the distance
    that the arm had left when the next sample arrived is lost: the tool drifts. Rotation counts from the reference.
    """

    def engage(self, hand_in_operator: Array, operator_R_hand: Array | None, base_T_tool: Array) -> None:
        """Capture both origins; the next displacement counts from this hand."""
        super().engage(hand_in_operator, operator_R_hand, base_T_tool)
        self._hand = hand_in_operator.copy()

    def read(self, base_T_tool: Array) -> None:
        """Begin the next displacement at the measured tool."""
        self._offset = base_T_tool[:3, 3] - self._gain @ self._hand

    def target(self, hand_in_operator: Array, operator_R_hand: Array | None) -> Array:
        """The target `base_T_tool` (4 x 4): the measured position plus the hand's motion since the last sample."""
        self._hand = hand_in_operator.copy()
        return super().target(hand_in_operator, operator_R_hand)


def make_mapping(config: MappingConfig) -> Mapping:
    """The configured mapping."""
    return IncrementalMapping(config) if config.command == "incremental" else Mapping(config)


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


def _proper_rotation(config: MappingConfig) -> Array:
    rotation = np.array(config.base_R_operator)
    finite = bool(np.isfinite(rotation).all())
    if not finite or np.abs(rotation @ rotation.T - np.eye(3)).max() > PROPER or np.linalg.det(rotation) < 0:
        raise ConfigError(
            "mapping.base_R_operator is not a proper rotation; its rows must be orthogonal unit vectors, "
            "and the third the cross product of the first two"
        )
    return rotation

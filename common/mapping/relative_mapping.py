"""From the hand's motion to the tool's target, relative to both origins; pure."""

from typing import Protocol

import numpy as np
from msgspec.structs import replace

from common.errors import ConfigError
from common.geometry import Array, transform
from common.mapping.rotation_mapping import RotationMapping
from common.messages.base import Vector3
from common.messages.hand import HandArm, OperatorSettings
from common.messages.robot import MappingReference

PROPER = 1e-6


class MappingLocks(Protocol):
    """Motions that the arm does not copy: along the base's axes, and about the tool's."""

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


class MappingParameters(Protocol):
    """The remote site's settings of the mapping, as its own table or as the description of its cell."""

    @property
    def scale(self) -> float: ...
    @property
    def scale_range(self) -> tuple[float, float]: ...
    @property
    def base_R_operator(self) -> tuple[Vector3, Vector3, Vector3]: ...
    @property
    def locks(self) -> MappingLocks: ...


class RelativeMapping:
    """Moves the tool as the hand has moved since its reference, in the robot's world axes (thesis section 4.2).

    While the hand shows no orientation (thumb hidden, hand open) the tool keeps its own; when the orientation is back,
    the hand's rotation counts from there, so the tool never swings. A change of the settings never moves the target.
    """

    def __init__(self, config: MappingParameters) -> None:
        self._base_R_operator = _proper_rotation(config)
        self._config = config
        self._rotation = RotationMapping(self._base_R_operator)
        self._apply(OperatorSettings())
        self.engage(np.zeros(3), None, np.eye(4))

    def engage(self, hand_in_operator: Array, operator_R_hand: Array | None, base_T_tool: Array) -> None:
        """Capture both origins: from here the target is `base_T_tool` plus the hand's motion."""
        self._offset = base_T_tool[:3, 3] - self._gain @ hand_in_operator
        self._rotation.engage(operator_R_hand, base_T_tool[:3, :3])

    def steer(
        self, settings: OperatorSettings, hand_in_operator: Array, operator_R_hand: Array | None, base_T_target: Array
    ) -> None:
        """Apply the operator's settings; a change captures both origins again, the tool's from the present target."""
        if settings != self._settings:
            self._apply(settings)
            self.engage(hand_in_operator, operator_R_hand, base_T_target)

    def target(self, hand_in_operator: Array, operator_R_hand: Array | None) -> Array:
        """The target `base_T_tool` (4 x 4) for the hand's position (3,) in m and orientation, None if it shows none."""
        return transform(self._rotation.target(operator_R_hand), self._offset + self._gain @ hand_in_operator)

    def read(self, base_T_tool: Array) -> None:
        """Take where the tool was sent when a sample comes; a target relative to both origins ignores it."""

    def elbow(self, wrist_in_operator: Vector3 | Array | None, elbow_in_operator: Vector3 | None) -> Array | None:
        """The operator's elbow from the wrist (3,) in m in the base's axes, None while one of them is not seen."""
        if elbow_in_operator is None or wrist_in_operator is None:
            return None
        elbow: Array = self._base_R_operator @ (np.array(elbow_in_operator) - np.array(wrist_in_operator))
        return elbow

    def bounded(self, settings: OperatorSettings) -> OperatorSettings:
        """The settings with their scale such that its product with the configured one is in `scale_range`."""
        least, most = (bound / self._config.scale for bound in self._config.scale_range)
        return replace(settings, scale=min(max(settings.scale, least), most))

    def reference(self, sample: HandArm, hand_R_followed: Array | None) -> MappingReference | None:
        """Return what the next targets count from, after that of `sample`; None where they depend on the tool too.

        The target followed the orientation that the sample shows times `hand_R_followed` (3 x 3); None where it showed
        none that counted.
        """
        x, y, z = self._offset.tolist()
        offset, rotation = (x, y, z), self._rotation.reference(hand_R_followed)
        return MappingReference(sample.session, sample.seq, self._settings.revision, offset, rotation)

    def restore(self, reference: MappingReference, settings: OperatorSettings) -> None:
        """Go on from a reference; `settings` are those under which it was captured."""
        self._apply(settings)
        self._offset = np.array(reference.offset)
        self._rotation.restore(reference.rotation)

    def _apply(self, settings: OperatorSettings) -> None:
        """Set the gain (3 x 3) from the hand's displacement in the operator frame to the tool's in the base frame."""
        own, theirs = self._config.locks, settings.locks
        moving = np.array([not (own.x or theirs.x), not (own.y or theirs.y), not (own.z or theirs.z)], dtype=float)
        self._gain = (self._config.scale * settings.scale * moving)[:, None] * self._base_R_operator
        free = np.array(
            [not (own.yaw or theirs.yaw), not (own.pitch or theirs.pitch), not (own.roll or theirs.roll)], dtype=float
        )
        self._rotation.steer(free, settings.rotation_scale)
        self._settings = settings


def _proper_rotation(config: MappingParameters) -> Array:
    rotation = np.array(config.base_R_operator)
    finite = bool(np.isfinite(rotation).all())
    if not finite or np.abs(rotation @ rotation.T - np.eye(3)).max() > PROPER or np.linalg.det(rotation) < 0:
        raise ConfigError(
            "mapping.base_R_operator is not a proper rotation; its rows must be orthogonal unit vectors, "
            "and the third the cross product of the first two"
        )
    return rotation

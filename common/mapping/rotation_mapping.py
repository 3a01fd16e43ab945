"""From the hand's rotation to the tool's, with the operator's locks and scale; pure."""

import math

import numpy as np

from common.geometry import (
    Array,
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_vector,
    unwound,
    vector_from_rotation,
)
from common.messages.base import Quaternion
from common.messages.robot import RotationReference

NO_AXIS = 1e-6  # sine of the angle between two axes: below it they are parallel or opposite


class RotationMapping:
    """Rotates the tool as the hand has turned since its reference, scaled, and without the locked rotations.

    Locks apply to the rotation since engagement, in the tool's axes at that time. While the hand shows no orientation
    the tool keeps its own; the hand's rotation counts from where its orientation is back.
    """

    def __init__(self, base_R_operator: Array) -> None:
        self._base_R_operator = base_R_operator
        self.steer(np.ones(3), 1.0)
        self.engage(None, np.eye(3))

    def steer(self, free: Array, scale: float) -> None:
        """Set which rotations about the tool's x, y and z are free (3,), 1 or 0, and the scale of the hand's."""
        self._free, self._scale = free, scale
        self._locked = not free.all()

    def engage(self, operator_R_hand: Array | None, base_R_tool: Array) -> None:
        """Capture both orientations: from here the target is `base_R_tool` (3 x 3) plus the hand's rotation."""
        self._base_R_origin = self._base_R_unlocked = base_R_tool.copy()
        self._capture(operator_R_hand)

    def target(self, operator_R_hand: Array | None) -> Array:
        """The target `base_R_tool` (3 x 3) for the hand's orientation (3 x 3), None if it shows none."""
        self._update(operator_R_hand)
        if self._locked:
            return self._base_R_origin @ _without_locked(self._base_R_origin.T @ self._base_R_unlocked, self._free)
        return self._base_R_unlocked

    def reference(self, hand_R_followed: Array | None) -> RotationReference:
        """Return what the next targets count from, while hands go on as shown: `hand_R_followed` (3 x 3) stays fixed.

        It is the rotation from the followed to the shown orientation, None while the hand shows none.
        """
        hand, tool = self._operator_R_reference, self._base_R_reference
        if hand is not None:
            hand = hand @ hand_R_followed.T if hand_R_followed is not None else None
        x, y, z = self._rotation_vector.tolist()
        if self._scale == 1.0:  # the vector is not kept
            x, y, z = vector_from_rotation(self._base_R_unlocked @ tool.T).tolist()
        return RotationReference(
            operator_R_hand=_quaternion(hand) if hand is not None else None,
            base_R_tool=_quaternion(tool),
            turn=(x, y, z),
            base_R_locked=_quaternion(self._base_R_origin) if self._locked else None,
        )

    def restore(self, reference: RotationReference) -> None:
        """Go on from a reference, captured under the scale and locks that are set."""
        hand, locked = reference.operator_R_hand, reference.base_R_locked
        tool = rotation_from_quaternion(reference.base_R_tool)
        self._base_R_unlocked = tool
        self._capture(rotation_from_quaternion(hand) if hand is not None else None)
        self._rotation_vector = np.array(reference.turn)
        self._base_R_unlocked = rotation_from_vector(self._scale * self._rotation_vector) @ tool
        self._base_R_origin = rotation_from_quaternion(locked) if locked is not None else tool

    def _capture(self, operator_R_hand: Array | None) -> None:
        """Let the hand's rotation, if it shows one, count from here."""
        self._operator_R_reference, self._base_R_reference = operator_R_hand, self._base_R_unlocked
        self._rotation_vector = np.zeros(3)
        if operator_R_hand is not None:
            self._hand_R_tool = operator_R_hand.T @ self._base_R_operator.T @ self._base_R_unlocked

    def _update(self, operator_R_hand: Array | None) -> None:
        """Bring the target without locks up to date."""
        if operator_R_hand is None or self._operator_R_reference is None:
            self._capture(operator_R_hand)
        elif self._scale == 1.0:
            self._base_R_unlocked = self._base_R_operator @ operator_R_hand @ self._hand_R_tool
        else:
            turned = self._base_R_operator @ operator_R_hand @ self._operator_R_reference.T @ self._base_R_operator.T
            self._rotation_vector = unwound(vector_from_rotation(turned), self._rotation_vector)
            self._base_R_unlocked = rotation_from_vector(self._scale * self._rotation_vector) @ self._base_R_reference


def _quaternion(rotation: Array) -> Quaternion:
    x, y, z, w = quaternion_from_rotation(rotation).tolist()
    return x, y, z, w


def _without_locked(tool_R_turned: Array, free: Array) -> Array:
    """A rotation in the tool's axes with its free parts (3,), 1 or 0: z is the twist about z, the swing has x and y."""
    swing = _swing_to(tool_R_turned[:, 2])
    twist = swing.T @ tool_R_turned
    kept = rotation_from_vector(vector_from_rotation(swing) * np.array([free[0], free[1], 1.0]))
    return kept @ twist if free[2] else kept


def _swing_to(z: Array) -> Array:
    """The shortest rotation that takes the z axis to the unit vector `z`; about x when that is opposite."""
    sine = math.hypot(z[0], z[1])
    angle = math.atan2(sine, z[2])
    axis = np.array([-z[1], z[0], 0.0]) / sine if sine > NO_AXIS else np.array([1.0, 0.0, 0.0])
    return rotation_from_vector(angle * axis)

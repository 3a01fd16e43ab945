"""Steering of the hand so that the gripper, or the block in it, comes to its goal; when to bring it back."""

from typing import NamedTuple

import numpy as np

from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from common.messages.hand import OperatorSettings
from common.messages.requests import MappingDescription

# Where the hand stays, from its start: m in the operator frame, and rad.
LEAST, MOST = np.array([-0.16, -0.12, -0.14]), np.array([0.06, 0.15, 0.15])
MOST_TURN = np.radians(32)
WORTH = 0.5  # of a movement: with less room than for this part, the hand is brought back first
TINY_M = 1e-6


class Movement(NamedTuple):
    """A movement of the hand in the operator frame: by (3,) m and (3, 3)."""

    shift: Array
    turn: Array


class Steering:
    """Movements of the hand by what is seen of the arm, given how the arm follows the hand (thesis section 4.2).

    Who does not see how what it holds is turned trusts that it turns as the hand does.
    """

    def __init__(self, mapping: MappingDescription, roll_locked: bool, sees_turn: bool = True) -> None:
        self.sees_turn = sees_turn
        self._turned: Array | None = None
        self._operator_R_base = np.array(mapping.base_R_operator).T
        self._scale = mapping.scale
        self._roll_locked = roll_locked

    def believed(self, seen: Array, held: bool) -> Array:
        """The pose (4 x 4) that the operator goes by, of what is seen at a pose, and may be held."""
        if self.sees_turn or not held:
            self._turned = None
            return seen
        self._turned = self._turned if self._turned is not None else seen[:3, :3].copy()
        return transform(self._turned, seen[:3, 3])

    def begin(self, movement: Movement, settings: OperatorSettings) -> None:
        """Take note of a movement that the hand begins."""
        if self._turned is not None:
            turn = settings.rotation_scale * self._operator_R_base.T @ vector_from_rotation(movement.turn)
            self._turned = rotation_from_vector(turn) @ self._turned

    def possible_turn(self, turn: Array, gripper: Array) -> Array:
        """The part of a rotation vector (3,) in the base's axes that the locks of the `gripper` (4 x 4) allow."""
        along = gripper[:3, 2]
        return turn - (turn @ along) * along if self._roll_locked else turn

    def towards(self, goal: Array, moved: Array, gripper: Array, settings: OperatorSettings) -> Movement:
        """The movement that brings `moved` to the `goal`, both (4 x 4) in the base's frame.

        The arm turns about the middle of the fingers of the `gripper` (4 x 4), and not about the axis along which
        they point where the roll is locked.
        """
        turn = self.possible_turn(vector_from_rotation(goal[:3, :3] @ moved[:3, :3].T), gripper)
        fingers = gripper[:3, 3]
        shift = goal[:3, 3] - fingers - rotation_from_vector(turn) @ (moved[:3, 3] - fingers)
        hand_turn = self._operator_R_base @ turn / settings.rotation_scale
        return Movement(self._operator_R_base @ shift / (self._scale * settings.scale), rotation_from_vector(hand_turn))


def within_room(offset: Array, turned: Array, movement: Movement) -> Movement | None:
    """The part of a movement that stays in the hand's room; None where it is better to bring the hand back first.

    The hand is at `offset` (3,), m, and `turned` (3, 3) from its start.
    """
    part = _part(offset, movement.shift)
    angle, turned_by = _angle(movement.turn @ turned), _angle(turned)
    narrow = part < WORTH and part < 0.9 * _part(begin_of(movement.shift), movement.shift)
    if narrow or angle > max(MOST_TURN, turned_by):
        return None
    return Movement(part * movement.shift, movement.turn)


def begin_of(shift: Array) -> Array:
    """The offset (3,) from which the hand has most room for a movement (3,)."""
    return np.asarray(np.clip((LEAST + MOST) / 2 - shift / 2, 0.9 * LEAST, 0.9 * MOST))


def _part(offset: Array, shift: Array) -> float:
    """The part of a movement (3,), 0 to 1, that from an offset (3,) stays in the hand's room."""
    moves = np.abs(shift) > TINY_M
    room = np.where(shift > 0, MOST, LEAST) - offset
    return float(np.clip((room[moves] / shift[moves]).min(initial=1.0), 0.0, 1.0))


def _angle(rotation: Array) -> float:
    return float(np.linalg.norm(vector_from_rotation(rotation)))

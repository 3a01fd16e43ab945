"""The hand that leads the tool to a pose: the mapping of the remote site, the other way round; pure."""

import numpy as np

from common.errors import ConfigError
from common.geometry import Array, rotation_from_quaternion, rotation_from_vector, transform, vector_from_rotation
from common.messages.hand import OperatorSettings, TrackingStatus
from common.messages.requests import MappingDescription
from common.messages.robot import MappingReference
from local_site.tracking.tracker import ArmEstimate

INDEX_IN_HAND, THUMB_IN_HAND = np.array([0.16, -0.05, 0.0]), np.array([0.16, 0.05, 0.0])  # m; axes as hand_rotation
NO_ROTATION = 1e-3  # a smaller scale of the rotation leads the tool nowhere


def why_not_led(mapping: MappingDescription, settings: OperatorSettings) -> str:
    """Say why no hand can lead the tool to every pose, with the cure; empty when one can."""
    locked = [name for name in mapping.locks.__struct_fields__ if getattr(mapping.locks, name)]
    if locked:
        return f"the cell's configuration locks {', '.join(locked)} (mapping.locks): a path needs all motions free"
    locked = [name for name in settings.locks.__struct_fields__ if getattr(settings.locks, name)]
    if locked:
        return f"{', '.join(locked)} is locked on the page: unlock it, a path needs all motions free"
    if settings.rotation_scale < NO_ROTATION:
        return "the rotation's scale on the page is 0: set it to 1"
    return ""


def operator_T_hand(
    base_T_target: Array, mapping: MappingDescription, settings: OperatorSettings, reference: MappingReference
) -> Array:
    """The hand's pose (4 x 4, operator frame) that the remote site maps to `base_T_target` (4 x 4).

    `reference` is what its targets count from, under these settings. Of a tool that is turned by more than half a turn
    since then it is the shorter way round. ConfigError where the hand has shown no
    orientation yet, from which its rotation could count.
    """
    turning = reference.rotation
    if turning.operator_R_hand is None:
        raise ConfigError("the remote site has no orientation of the hand from which its rotation counts: engage again")
    base_R_operator = np.array(mapping.base_R_operator)
    position = base_R_operator.T @ (base_T_target[:3, 3] - np.array(reference.offset))
    turned = vector_from_rotation(base_T_target[:3, :3] @ rotation_from_quaternion(turning.base_R_tool).T)
    operator_turn = rotation_from_vector(base_R_operator.T @ turned / settings.rotation_scale)
    rotation = operator_turn @ rotation_from_quaternion(turning.operator_R_hand)
    return transform(rotation, position / (mapping.scale * settings.scale))


def shown_hand(operator_T_hand: Array, t_ns: int, status: TrackingStatus, reason: str) -> ArmEstimate:
    """Build what a tracker would measure of this hand (4 x 4); it has no elbow, for an arm is not shown."""
    return ArmEstimate(
        t_ns,
        status,
        reason,
        wrist=operator_T_hand[:3, 3].copy(),
        index=_at(operator_T_hand, INDEX_IN_HAND),
        thumb=_at(operator_T_hand, THUMB_IN_HAND),
        palm=operator_T_hand[:3, 3].copy(),
    )


def _at(operator_T_hand: Array, in_hand: Array) -> Array:
    point: Array = operator_T_hand[:3, :3] @ in_hand + operator_T_hand[:3, 3]
    return point

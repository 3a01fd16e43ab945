"""Known shapes of a cell: the arm's as capsules, its fixtures as boxes, the gripper's opening."""

from typing import Annotated

import msgspec

from common.messages.base import Name, Vector3

MOST_CAPSULES = 48
MOST_BOXES = 32
Size = Annotated[float, msgspec.Meta(gt=0)]
FrameIndex = Annotated[int, msgspec.Meta(ge=0, le=17)]


class CapsuleDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A capsule that moves with the arm: the ends of its axis in the frame of `link`, and its radius, m.

    Links are numbered from the base, 0, over the joints to the tool, one more than there are joints.
    """

    link: FrameIndex
    start: Vector3
    end: Vector3
    radius: Size


class BoxDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A fixed box along the axes of the base's frame, between two corners in m."""

    name: Name
    lower: Vector3
    upper: Vector3


class GripperDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Up to which opening between its fingers the gripper counts as closed, and from which as open, m."""

    closed: float
    open: float


class ShapesDescription(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The shapes of a cell, for drawing it; where the arm's are not known there are no capsules."""

    capsules: Annotated[tuple[CapsuleDescription, ...], msgspec.Meta(max_length=MOST_CAPSULES)]
    fixtures: Annotated[tuple[BoxDescription, ...], msgspec.Meta(max_length=MOST_BOXES)]
    gripper: GripperDescription

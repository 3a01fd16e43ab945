"""The task as the operator knows it beforehand: the block, the target, the table, the gripper; sizes in m."""

from dataclasses import dataclass, field
from itertools import product

import numpy as np

from common.geometry import Array, rotation_from_vector, transform


@dataclass(frozen=True, slots=True)
class PlacingTask:
    """Put the marked corner (+x, -y) of the block on the target's corner, edges aligned (thesis section 5.3).

    The block stands on the table, its height along z; the gripper's fingers close along its own y and point along z.
    """

    block_size: tuple[float, float, float] = (0.100, 0.050, 0.200)
    mark_width: float = 0.006
    target_side: float = 0.0765
    table_z: float = 0.558
    finger: tuple[float, float, float] = (0.022, 0.008, 0.0254)
    housing: tuple[float, float, float] = (0.052, 0.104, 0.065)
    grasp_above_middle: float = 0.04
    finger_overlap: float = 0.0215
    base_R_gripper: Array = field(default_factory=lambda: np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]))

    @property
    def tcp_T_fingers(self) -> Array:
        """The middle between the fingers (4 x 4) in the frame of the tool centre point, which is between their tips."""
        return transform(np.eye(3), np.array([0.0, 0.0, -self.finger[2] / 2]))

    def block_shape(self) -> Array:
        """The corners (8, 3) of the block about its middle."""
        return np.array(list(product(*((-size / 2, size / 2) for size in self.block_size))))

    def stripe_shape(self) -> Array:
        """The corners (8, 3) of the stripe along the block's marked edge, about the block's middle."""
        x, y, z = (size / 2 for size in self.block_size)
        return np.array(list(product((x - self.mark_width, x), (-y, -y + self.mark_width), (-z, z))))

    def paper_shape(self) -> Array:
        """The corners (4, 3) of the target about the corner that the block's belongs on."""
        s = self.target_side
        return np.array([(0, 0, 0), (-s, 0, 0), (-s, s, 0), (0, s, 0)])

    def marks_on(self, target: Array) -> Array:
        """The corners (3, 3) of the target's red marks, along the two edges that meet in its corner."""
        s, w = self.target_side / 2, self.mark_width / 2
        marks = np.array([(-s, -w, 0), (w, -w, 0), (w, s, 0)])
        return marks @ target[:3, :3].T + target[:3, 3]

    def finger_shape(self, opening: float, side: float) -> Array:
        """The corners (8, 3) of the finger at +y (`side` 1) or -y (-1) about the fingers' middle; the opening in m."""
        height, thickness, length = self.finger
        inner = side * opening / 2
        sides = (inner, inner + side * thickness)
        return np.array(list(product((-height / 2, height / 2), sides, (-length / 2, length / 2))))

    def fingers_shape(self, opening: float) -> Array:
        """The corners (16, 3) of both fingers about the middle between them, at an opening in m."""
        return np.concatenate([self.finger_shape(opening, side) for side in (1.0, -1.0)])

    def gripper_in_tool(self, opening: float) -> list[Array]:
        """The corners of housing and fingers (8, 3) each in the frame of the tool centre point; the opening in m."""
        x, y, z = self.housing
        housing = np.array(list(product((-x / 2, x / 2), (-y / 2, y / 2), (-self.finger[2] - z, -self.finger[2]))))
        return [housing, *(self.finger_shape(opening, side) + self.tcp_T_fingers[:3, 3] for side in (1.0, -1.0))]

    def upright(self, pose: Array) -> Array:
        """A pose (4 x 4) turned back until its z is up."""
        x, y = pose[:2, 0]
        return transform(rotation_from_vector(np.array([0.0, 0.0, np.arctan2(y, x)])), pose[:3, 3])

    def flat(self, target: Array) -> Array:
        """A target (4 x 4) that lies on the table as flat as paper does."""
        pose = self.upright(target)
        pose[2, 3] = self.table_z
        return pose

    def block_on(self, target: Array) -> Array:
        """The pose (4 x 4) of the block that stands on the target (4 x 4)."""
        x, y, z = self.block_size
        pose = target.copy()
        pose[:3, 3] += target[:3, :3] @ np.array([-x / 2, y / 2, z / 2])
        return pose

    def levelled(self, base_R_gripper: Array) -> Array:
        """The rotation of a level gripper that points the same way."""
        x, y = base_R_gripper[:2, 2]
        return rotation_from_vector(np.array([0.0, 0.0, np.arctan2(y, x)])) @ self.base_R_gripper

    def grasp_of(self, block: Array, back: float = 0.0, up: float = 0.0) -> Array:
        """The pose (4 x 4) of the gripper that grasps an upright block (4 x 4); `back` and `up` m away from it."""
        depth, _, length = self.block_size[0], self.block_size[1], self.finger[2]
        pose = block.copy()
        inside = -depth / 2 + self.finger_overlap - length / 2 - back
        pose[:3, 3] += block[:3, :3] @ np.array([inside, 0.0, self.grasp_above_middle + up])
        pose[:3, :3] = block[:3, :3] @ self.base_R_gripper
        return pose

"""The arm's pose in the camera's frame: two links joined at the elbow, and their motion between frames."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array, rotation_from_vector, vector_from_rotation

DAMPING = 0.7

Link = tuple[Array, Array]


@dataclass(frozen=True, slots=True)
class ArmPose:
    """The shoulder (3,) in m and `camera_R_link` (3, 3) of upper arm and forearm; links run along their z."""

    shoulder: Array
    upper_arm: Array
    forearm: Array
    upper_arm_length: float

    @property
    def elbow(self) -> Array:
        """The joint between the links (3,), m."""
        result: Array = self.shoulder + self.upper_arm_length * self.upper_arm[:, 2]
        return result

    @property
    def links(self) -> tuple[Link, Link]:
        """Joint (3,) and rotation (3, 3) of upper arm and forearm."""
        return (self.shoulder, self.upper_arm), (self.elbow, self.forearm)

    def on_upper_arm(self, point: Array) -> Array:
        """A point (3,) of the upper arm's frame in the camera's, m."""
        result: Array = self.shoulder + self.upper_arm @ point
        return result

    def on_forearm(self, point: Array) -> Array:
        """A point (3,) of the forearm's frame in the camera's, m."""
        result: Array = self.elbow + self.forearm @ point
        return result

    def moved(self, translation: Array, upper_turn: Array, forearm_turn: Array) -> "ArmPose":
        """The pose after a translation (3,) in m of the shoulder and small rotations (3,) in rad of both links, about
        the camera's axes (eq. 1-4)."""
        return ArmPose(
            self.shoulder + translation,
            rotation_from_vector(upper_turn) @ self.upper_arm,
            rotation_from_vector(forearm_turn) @ self.forearm,
            self.upper_arm_length,
        )


def predicted(before: ArmPose, last: ArmPose) -> ArmPose:
    """The next pose if the last motion continues, damped."""
    return last.moved(
        DAMPING * (last.shoulder - before.shoulder),
        DAMPING * vector_from_rotation(last.upper_arm @ before.upper_arm.T),
        DAMPING * vector_from_rotation(last.forearm @ before.forearm.T),
    )


def facing(along: Array, turn: float) -> Array:
    """`camera_R_link` of a link along a direction (3,) with its palm parallel to the image, rotated about it by `turn`
    in rad; undefined for a link along the optical axis."""
    z = along / np.linalg.norm(along)
    deep = np.array([0.0, 0.0, 1.0]) - z[2] * z
    deep /= np.linalg.norm(deep)
    rotation: Array = np.column_stack([np.cross(deep, z), deep, z]) @ rotation_from_vector(np.array([0.0, 0.0, turn]))
    return rotation

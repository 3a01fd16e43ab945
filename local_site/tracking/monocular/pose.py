"""Where the arm is in the camera's frame: two links, one joint between them, and how they move from frame to frame."""

from dataclasses import dataclass

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
        """The pose after a translation (3,) in m of the shoulder and small turns (3,) in rad of both links (eq. 1-4).

        The elbow follows the upper arm; the turns are about the camera's axes.
        """
        return ArmPose(
            self.shoulder + translation,
            rotation_from_vector(upper_turn) @ self.upper_arm,
            rotation_from_vector(forearm_turn) @ self.forearm,
            self.upper_arm_length,
        )


def predicted(before: ArmPose, last: ArmPose, damping: float = DAMPING) -> ArmPose:
    """The next pose when the last motion goes on, damped."""
    return last.moved(
        damping * (last.shoulder - before.shoulder),
        damping * vector_from_rotation(last.upper_arm @ before.upper_arm.T),
        damping * vector_from_rotation(last.forearm @ before.forearm.T),
    )

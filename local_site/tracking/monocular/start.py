"""The pose in the first picture from the joints' places there, both links parallel to the picture (section 2.6)."""

import math

import numpy as np

from common.geometry import Array, rotation_from_vector
from local_site.calibration.lens import Lens
from local_site.tracking.monocular.arm_mesh import MM
from local_site.tracking.monocular.config import MonocularConfig
from local_site.tracking.monocular.pose import ArmPose

MOST_UNEQUAL = 1.15


def starting_pose(lens: Lens, config: MonocularConfig, pixels: Array) -> ArmPose | str:
    """The pose for the joints at pixels (3, 2) of a pinhole's picture; a sentence why not.

    The links' lengths give a depth each; they have to agree, and their mean by length is taken.
    """
    slopes = (pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    lengths = MM * np.array([config.upper_arm.length_mm, config.forearm.length_mm])
    seen = np.linalg.norm(np.diff(slopes, axis=0), axis=1)
    depths = lengths / seen
    if max(depths) > MOST_UNEQUAL * min(depths):
        told = ", ".join(f"{depth:.2f} m" for depth in depths)
        return f"the links do not look equally far in the first picture ({told}): hold both parallel to the picture"
    places = np.column_stack([slopes, np.ones(3)]) * float(lengths.sum() / seen.sum())
    upper_arm = facing(places[1] - places[0], 0.0)
    forearm = facing(places[2] - places[1], math.radians(config.start.palm_turn_deg))
    return ArmPose(places[0], upper_arm, forearm, float(lengths[0]))


def facing(along: Array, turn: float) -> Array:
    """`camera_R_link` of a link along a direction (3,), its palm flat before the camera but for a turn about it in rad.

    A link that points at the camera has no such rotation.
    """
    z = along / np.linalg.norm(along)
    deep = np.array([0.0, 0.0, 1.0]) - z[2] * z
    deep /= np.linalg.norm(deep)
    rotation: Array = np.column_stack([np.cross(deep, z), deep, z]) @ rotation_from_vector(np.array([0.0, 0.0, turn]))
    return rotation

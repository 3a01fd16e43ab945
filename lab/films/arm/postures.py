"""Postures of the hand: the joints' angles of each by name."""

from typing import Literal

import numpy as np

from common.geometry import Array

PostureName = Literal["u_shape", "open", "fist", "pointing", "flat"]
DIGITS = ("thumb", "index", "middle", "ring", "little")

# Degrees relative to the mesh at rest. Fingers: flexion at knuckle, middle and last joint, spreading to the thumb's
# side. Thumb: opposition (about the hand's axis, to the palm's side), flexion of its two outer joints, abduction.
_POSTURES: dict[PostureName, dict[str, tuple[float, float, float, float]]] = {
    "u_shape": {
        "thumb": (34.0, -8.0, -6.0, 0.0),
        "index": (8.0, 4.0, 0.0, 2.0),
        "middle": (12.0, 10.0, 4.0, 0.0),
        "ring": (18.0, 16.0, 8.0, 0.0),
        "little": (22.0, 18.0, 8.0, 0.0),
    },
    "open": {
        "thumb": (5.0, -10.0, -10.0, 12.0),
        "index": (-20.0, -16.0, -8.0, 8.0),
        "middle": (-20.0, -16.0, -8.0, 1.0),
        "ring": (-20.0, -16.0, -8.0, -6.0),
        "little": (-20.0, -16.0, -8.0, -14.0),
    },
    "fist": {
        "thumb": (22.0, 26.0, 40.0, -20.0),
        "index": (58.0, 80.0, 45.0, 0.0),
        "middle": (60.0, 82.0, 48.0, 0.0),
        "ring": (60.0, 82.0, 48.0, 2.0),
        "little": (60.0, 78.0, 45.0, 6.0),
    },
    "pointing": {
        "thumb": (22.0, 24.0, 36.0, -18.0),
        "index": (-12.0, -14.0, -8.0, 0.0),
        "middle": (58.0, 80.0, 45.0, 0.0),
        "ring": (60.0, 82.0, 48.0, 2.0),
        "little": (60.0, 78.0, 45.0, 6.0),
    },
    "flat": {
        "thumb": (0.0, -4.0, -4.0, -10.0),
        "index": (-18.0, -16.0, -8.0, -2.0),
        "middle": (-18.0, -16.0, -8.0, 0.0),
        "ring": (-18.0, -16.0, -8.0, 1.0),
        "little": (-18.0, -16.0, -8.0, 3.0),
    },
}


def posture_angles(name: PostureName) -> Array:
    """The angles (5, 4) in rad of the digits in the order of DIGITS."""
    return np.radians([_POSTURES[name][digit] for digit in DIGITS])

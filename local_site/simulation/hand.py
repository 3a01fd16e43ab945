"""The hand of the simulated arm: palm, four fingers and thumb, between a posture at rest and spread fingers.

Hand frame, m: origin in the wrist's centre, x distal along the palm, y radial (the thumb's side), z dorsal.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.simulation.config import PostureName

DIGITS = ("index", "middle", "ring", "little", "thumb")
JOINTS = 4


@dataclass(frozen=True, slots=True)
class FingerPosture:
    """One shape of all five digits.

    `forward` (5, 3) points along each straight digit, `curl` (5, 3) to where it bends, `bend_deg` (5, 3) is the
    direction of each of its three bones, counted from `forward`.
    """

    forward: Array
    curl: Array
    bend_deg: Array


BASES = np.array(
    [
        [0.089, 0.026, 0.002],
        [0.090, 0.005, 0.004],
        [0.087, -0.016, 0.002],
        [0.079, -0.034, -0.003],
        [0.029, 0.020, -0.012],
    ]
)
BONES = np.array(
    [[0.046, 0.026, 0.018], [0.048, 0.028, 0.019], [0.046, 0.028, 0.019], [0.037, 0.021, 0.017], [0.046, 0.034, 0.022]]
)
RADII = np.array(
    [
        [0.0130, 0.0098, 0.0086, 0.0068],
        [0.0130, 0.0100, 0.0088, 0.0070],
        [0.0125, 0.0094, 0.0082, 0.0066],
        [0.0120, 0.0084, 0.0074, 0.0060],
        [0.0150, 0.0145, 0.0112, 0.0085],
    ]
)
HYPOTHENAR = np.array([0.036, -0.022, -0.009])
HYPOTHENAR_RADIUS = 0.017
THENAR_RADIUS = 0.0165
WEB_RADIUS = 0.0095
# Markers beside the tips, from the tip on the skin (thesis figure 5.4): back along the last bone, and out of its side.
BACK_FROM_TIP = 0.010
BESIDE_INDEX, BESIDE_THUMB = 0.011, 0.012
# The ball of the thumb lies on the palm's side of its bone.
THENAR_INWARD = np.array([0.0, 0.006, 0.002])


def _posture(fan_deg: tuple[float, ...], thumb: Array, thumb_curl: Array, bend_deg: list[list[float]]) -> FingerPosture:
    angles, down = np.radians(fan_deg), np.tile([0.0, 0.0, -1.0], (4, 1))
    fan = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    return FingerPosture(np.vstack([fan, thumb]), np.vstack([down, thumb_curl]), np.array(bend_deg))


U_SHAPE = _posture(
    fan_deg=(-3, 0, 4, 9),
    thumb=np.array([0.60, 0.10, -0.79]),
    thumb_curl=np.array([0.79, 0.0, 0.60]),
    bend_deg=[[4, 15, 22], [8, 24, 36], [8, 25, 38], [5, 21, 32], [0, 20, 36]],
)
SPREAD = _posture(
    fan_deg=(17, 3, -11, -27),
    thumb=np.array([0.62, 0.78, -0.10]),
    thumb_curl=np.array([0.78, -0.62, 0.0]),
    bend_deg=[[-4, 0, 2], [-4, 0, 2], [-4, 0, 2], [-4, 0, 2], [0, 0, -8]],
)
FIST = _posture(
    fan_deg=(-4, -1, 3, 7),
    thumb=np.array([0.72, -0.05, -0.69]),
    thumb_curl=np.array([0.25, -0.90, 0.30]),
    bend_deg=[[78, 172, 236], [80, 176, 240], [80, 176, 240], [78, 172, 236], [0, 34, 78]],
)
POINTING = _posture(
    fan_deg=(2, -1, 3, 7),
    thumb=np.array([0.72, -0.05, -0.69]),
    thumb_curl=np.array([0.25, -0.90, 0.30]),
    bend_deg=[[2, 8, 12], [78, 172, 236], [80, 176, 240], [78, 172, 236], [0, 30, 72]],
)
FLAT = _posture(
    fan_deg=(3, 0, -3, -7),
    thumb=np.array([0.88, 0.44, -0.16]),
    thumb_curl=np.array([0.44, -0.88, 0.0]),
    bend_deg=[[2, 4, 6], [2, 4, 6], [2, 4, 6], [2, 4, 6], [0, 4, 4]],
)
POSTURES: Mapping[PostureName, FingerPosture] = {"u": U_SHAPE, "fist": FIST, "pointing": POINTING, "flat": FLAT}


class Hand:
    """The hand at a size: its balls and tips for every openness, from a posture at rest (0) to spread fingers (1)."""

    def __init__(self, scale: float, rest: FingerPosture = U_SHAPE) -> None:
        self._scale = scale
        self._rest = rest
        palm_radii = [HYPOTHENAR_RADIUS, THENAR_RADIUS, WEB_RADIUS, WEB_RADIUS]
        self.radii = scale * np.concatenate([RADII.ravel(), palm_radii])

    def balls(self, openness: float) -> Array:
        """Centres (24, 3) of the balls: four for each digit from base to tip, hypothenar, thenar and the web's two."""
        joints, _ = self._joints(openness)
        thumb, index = joints[4], joints[0]
        thenar = _blend(thumb[0], thumb[1], 0.4) - THENAR_INWARD
        web = _blend(thumb[0], thumb[1], 0.6), _blend(index[0], thumb[0], 0.15)
        return self._scale * np.concatenate([joints.reshape(-1, 3), [HYPOTHENAR, thenar, *web]])

    def tips(self, openness: float) -> tuple[Array, Array]:
        """The tips of index and thumb on the skin, (3,) each."""
        joints, last = self._joints(openness)
        skin = joints[:, 3] + RADII[:, 3:] * last
        return self._scale * skin[0], self._scale * skin[4]

    def beside_tips(self, openness: float) -> Array:
        """Return where markers sit beside the tips (2, 3): on the index's radial side, on the back of the thumb."""
        bones = self._joints(openness)[1]
        backs = self.backs(openness)[:, 2]
        radial = np.cross(backs[0], bones[0])
        index, thumb = self.tips(openness)
        return np.array(
            [
                index - BACK_FROM_TIP * bones[0] + BESIDE_INDEX * radial,
                thumb - BACK_FROM_TIP * bones[4] + BESIDE_THUMB * backs[4],
            ]
        )

    def joints(self, openness: float) -> Array:
        """Joint centres (5, 4, 3) of the digits, from base to tip; the last is that of the tip's ball."""
        return self._scale * self._joints(openness)[0]

    def backs(self, openness: float) -> Array:
        """Unit vectors (5, 3, 3) out of the back of each bone, where the last bone has its nail."""
        forward, curl, bend = self._bends(openness)
        return np.sin(bend) * forward[:, None] - np.cos(bend) * curl[:, None]

    def _joints(self, openness: float) -> tuple[NDArray[np.float64], Array]:
        """Joint centres (5, 4, 3) at scale 1, and the direction of each last bone (5, 3)."""
        forward, curl, bend = self._bends(openness)
        bones = np.cos(bend) * forward[:, None] + np.sin(bend) * curl[:, None]
        joints = np.empty((len(DIGITS), JOINTS, 3))
        joints[:, 0] = BASES
        joints[:, 1:] = BASES[:, None] + np.cumsum(BONES[..., None] * bones, axis=1)
        return joints, bones[:, 2]

    def _bends(self, openness: float) -> tuple[Array, Array, Array]:
        """Along each straight digit and to where it bends, (5, 3) each, and how far its bones do, (5, 3, 1) in rad."""
        rest = self._rest
        forward = unit(_blend(rest.forward, SPREAD.forward, openness))
        curl = _blend(rest.curl, SPREAD.curl, openness)
        curl = unit(curl - np.vecdot(curl, forward)[:, None] * forward)
        return forward, curl, np.radians(_blend(rest.bend_deg, SPREAD.bend_deg, openness))[..., None]


def _blend(a: Array, b: Array, fraction: float) -> Array:
    return (1.0 - fraction) * a + fraction * b


def unit(vectors: Array) -> Array:
    """Vectors (..., 3) of length 1 along these."""
    unit: Array = vectors / np.sqrt(np.vecdot(vectors, vectors))[..., None]
    return unit

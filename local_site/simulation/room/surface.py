"""The arm's surface for shading: many balls between those of the solid, each with its back and its colours of skin."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.simulation.body import ArmBody, BodyPose, Part
from local_site.simulation.hand import DIGITS
from local_site.simulation.room.config import SkinName

Colour = tuple[int, int, int]

SPACING = 0.5  # of the smaller radius: closer balls would look no smoother
MOTTLE = 0.035
NAIL_FROM, CREASE_FROM, FLUSH_FROM = 0.5, 0.86, 0.3
CREASE = 0.80
SKIN_TURN, NAIL_TURN = (0.5, 0.9), (-2.6, 5.0)
# Any pose does to count the balls that fit between two.
STRETCHED = BodyPose(np.zeros(3), np.array([0.0, 0.1, -0.3]), np.array([0.3, 0.0, -0.3]), np.eye(3), openness=1.0)


@dataclass(frozen=True, slots=True)
class SkinTone:
    """Colours as pictures show them in full light: red, green, blue, 0 to 255."""

    back: Colour
    palm: Colour
    nail: Colour
    flush: Colour


TONES: Mapping[SkinName, SkinTone] = {
    "light": SkinTone(back=(226, 178, 152), palm=(232, 184, 164), nail=(240, 202, 190), flush=(224, 158, 136)),
    "medium": SkinTone(back=(192, 140, 106), palm=(210, 160, 132), nail=(220, 174, 152), flush=(182, 120, 92)),
    "dark": SkinTone(back=(124, 84, 62), palm=(176, 130, 106), nail=(178, 134, 118), flush=(106, 66, 48)),
}


@dataclass(frozen=True, slots=True)
class Coat:
    """The look of M balls: reflectances (M, 3), blue first, on the palm's side and on the back, and where one
    becomes the other: `turn` (M, 2) is a + b cos(angle between normal and back), cut off at 0 and 1."""

    palm: Array
    back: Array
    turn: Array


class ArmSurface:
    """The balls between those of an arm: weights (M, N + 1) give M balls from N, and one that stands for the rim."""

    def __init__(self, body: ArmBody) -> None:
        solid = body.solid(STRETCHED)
        centres = np.vstack([solid.centres, solid.rim.mean(axis=0)])
        self._digits = [part for part in body.parts if part.name in DIGITS]
        self.weights = between(body.parts, centres, np.append(solid.radii, solid.radii.max()))

    def coat(self, tone: SkinTone, random: np.random.Generator) -> Coat:
        """Skin of this tone, a little mottled."""
        count = len(self.weights)
        mottle = 1.0 + MOTTLE * random.standard_normal((count, 1))
        palm, back = np.tile(reflectance(tone.palm), (count, 1)), np.tile(reflectance(tone.back), (count, 1))
        turn = np.tile(SKIN_TURN, (count, 1))
        for digit in self._digits:
            self._finish(digit, tone, palm, back, turn)
        return Coat(palm * mottle, back * mottle, turn)

    def _finish(self, digit: Part, tone: SkinTone, palm: Array, back: Array, turn: Array) -> None:
        """Redder joints and tips, creases on the palm's side, a nail at the end."""
        *_, middle, last, tip = dict.fromkeys(digit.balls.tolist())
        flush = reflectance(tone.flush)
        for joint in (middle, last):
            near = np.maximum(self.weights[:, joint] - FLUSH_FROM, 0.0)[:, None]
            back += near * (flush - back)
            palm[self.weights[:, joint] > CREASE_FROM] *= CREASE
        at_end = self.weights[:, tip]
        palm += 0.6 * at_end[:, None] * (flush - palm)
        nail = at_end > NAIL_FROM
        back[nail], turn[nail] = reflectance(tone.nail), NAIL_TURN


def reflectance(colour: Colour) -> Array:
    """The fraction of light (3,) that a surface of this colour throws back, in the order blue, green, red."""
    linear: Array = (np.array(colour[::-1]) / 255.0) ** 2.2
    return linear


def between(parts: tuple[Part, ...], centres: Array, radii: Array, spacing: float = SPACING) -> NDArray[np.float64]:
    """Weights (M, N) of balls along every line between two of the N balls of a piece."""
    rows = []
    for part in parts:
        for piece in part.pieces:
            for a, b in combinations(piece.tolist(), 2):
                length = float(np.linalg.norm(centres[b] - centres[a]))
                count = 2 + int(length / (spacing * min(radii[a], radii[b])))
                row = np.zeros((count, len(centres)))
                row[:, b] = np.linspace(0.0, 1.0, count)
                row[:, a] += 1.0 - row[:, b]
                rows.append(row)
    return np.unique(np.vstack(rows).round(6), axis=0)

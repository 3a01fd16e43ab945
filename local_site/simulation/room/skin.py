"""The colours of bare skin by tone: the back of a limb, the palm, nails, creases."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.simulation.room.config import SkinName

Colour = tuple[int, int, int]


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


def reflectance(colour: Colour) -> Array:
    """The fraction of light (3,) that a surface of this colour throws back, in the order blue, green, red."""
    linear: Array = (np.array(colour[::-1]) / 255.0) ** 2.2
    return linear

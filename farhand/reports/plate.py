"""Pictures side by side, each with a caption, as one PNG."""

from collections.abc import Sequence

import cv2
import numpy as np

from common.cameras.camera import Image
from local_site.kernels.pictures import as_colour

CAPTION_PX, GAP_PX, INSET_PX = 24, 4, 6
WHITE, INK = (255, 255, 255), (40, 40, 40)
FONT, FONT_SCALE = cv2.FONT_HERSHEY_SIMPLEX, 0.5


def plate(tiles: Sequence[tuple[str, Image]], columns: int, width_px: int) -> bytes:
    """The PNG of pictures, grey or BGR and all of one size, with their captions below, row by row.

    Each is scaled to a width of `width_px`. There has to be a picture at least.
    """
    drawn = [_tile(caption, picture, width_px) for caption, picture in tiles]
    drawn += [np.full_like(drawn[0], 255)] * (-len(drawn) % columns)
    rows = [np.hstack(drawn[first : first + columns]) for first in range(0, len(drawn), columns)]
    return cv2.imencode(".png", np.vstack(rows))[1].tobytes()


def _tile(caption: str, picture: Image, width_px: int) -> Image:
    height_px = round(picture.shape[0] * width_px / picture.shape[1])
    scaled = cv2.resize(as_colour(picture), (width_px, height_px), interpolation=cv2.INTER_AREA)
    tile = cv2.copyMakeBorder(scaled, 0, CAPTION_PX, 0, GAP_PX, cv2.BORDER_CONSTANT, value=WHITE)
    at = (INSET_PX, height_px + CAPTION_PX - INSET_PX)
    return np.asarray(cv2.putText(tile, caption, at, FONT, FONT_SCALE, INK, 1, cv2.LINE_AA), dtype=np.uint8)

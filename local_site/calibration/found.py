"""Pictures of what a calibration found, for a person to check: each point with its name."""

from collections.abc import Sequence

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array

CROSS, NAME = (60, 220, 60), (60, 200, 255)


def draw_found(picture: Image, pixels: Array, names: Sequence[str]) -> Image:
    """The picture in colour (H, W, 3) with a cross and a name at each of the pixels (N, 2), joined in their order."""
    colour = picture if picture.ndim == 3 else cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR)
    canvas = np.array(colour, dtype=np.uint8)
    places = [(round(float(u)), round(float(v))) for u, v in pixels]
    cv2.polylines(canvas, [np.array(places, dtype=np.int32).reshape(-1, 1, 2)], False, NAME, 1, cv2.LINE_AA)
    for place, name in zip(places, names, strict=True):
        cv2.drawMarker(canvas, place, CROSS, cv2.MARKER_CROSS, 9, 1, cv2.LINE_AA)
        cv2.putText(canvas, name, (place[0] + 5, place[1] - 5), cv2.FONT_HERSHEY_SIMPLEX, 0.35, NAME, 1, cv2.LINE_AA)
    return canvas

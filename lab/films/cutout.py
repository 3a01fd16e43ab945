"""The arm of a recording, cut out of its dark wall by brightness: a soft matte, and the arm's own grey under it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image

ARM_ABOVE = 26  # grey levels; the wall stays below
SURE_PX, EDGE_PX = 3, 3  # how far inside and outside of the arm's edge the matte is mixed
INNER_SIGMA_PX = 3.0
LEAST_CONTRAST = 20.0


@dataclass(frozen=True, slots=True)
class Cutout:
    """A part of a picture from `left`, `top`: the arm's grey levels (h, w), and how much of each pixel (h, w) it is,
    from 0 to 255."""

    left: int
    top: int
    grey: Image
    matte: Image


def cut_out(image: Image) -> Cutout | None:
    """The brightest thing before the dark wall of a picture (H, W, 3) or (H, W); None where all is dark."""
    grey = image if image.ndim == 2 else np.asarray(image[..., 1], dtype=np.uint8)
    bright = (cv2.GaussianBlur(grey, (0, 0), 1.0) > ARM_ABOVE).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(bright)
    if count < 2:
        return None
    arm = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    x, y, width, height = (int(v) for v in stats[arm, :4])
    margin = 2 * EDGE_PX
    left, top = max(x - margin, 0), max(y - margin, 0)
    part = np.s_[top : y + height + margin, left : x + width + margin]
    wall = float(np.median(grey[bright == 0]))
    return Cutout(left, top, *_matted(grey[part], (labels[part] == arm).astype(np.uint8), wall))


def _matted(grey: Image, mask: NDArray[np.uint8], wall: float) -> tuple[Image, Image]:
    """The arm's levels carried on over its edge, and the matte by which the picture mixes them with the wall."""
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
    sure = cv2.erode(mask, disc, iterations=SURE_PX).astype(np.float32)
    levels = grey.astype(np.float32)
    weight = cv2.GaussianBlur(sure, (0, 0), INNER_SIGMA_PX)
    carried = cv2.GaussianBlur(levels * sure, (0, 0), INNER_SIGMA_PX) / np.maximum(weight, 1e-3)
    known = weight > 1e-3
    matte = np.clip((levels - wall) / np.maximum(carried - wall, LEAST_CONTRAST), 0.0, 1.0)
    near = cv2.dilate(mask, disc, iterations=EDGE_PX) > 0
    matte = np.where(sure > 0, 1.0, np.where(near & known, matte, mask * near))
    arm = np.where(sure > 0, levels, np.where(known, carried, levels))
    return arm.astype(np.uint8), np.rint(255.0 * matte).astype(np.uint8)

"""Sharpness of a board in a picture: the blur of its edges."""

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array

REACH_PX = 7
GRADIENT_VARIANCE = 2 / 3  # of Sobel's own smoothing along the edge's normal, px²


def edge_blur_px(grey: Image, corners: Array) -> float:
    """The blur of the edges around a board's corners (M, 2) in a grey picture (H, W): a Gaussian's sigma, median, px.

    Infinite if no corner is far enough from the picture's border.
    """
    steepness = [_steepness(grey, u, v) for u, v in np.round(corners).astype(int).tolist()]
    known = [value for value in steepness if value is not None]
    if not known:
        return float(np.inf)
    # The greatest slope of a step that is blurred by sigma is its height over sigma sqrt(2 pi).
    sigma = 1.0 / (max(float(np.median(known)), 1e-6) * np.sqrt(2 * np.pi))
    return float(np.sqrt(max(sigma**2 - GRADIENT_VARIANCE, 0.0)))


def _steepness(grey: Image, u: int, v: int) -> float | None:
    """The greatest slope around a corner over the step's height, 1/px; None at the border."""
    height, width = grey.shape
    reach = REACH_PX
    if not (reach <= u < width - reach and reach <= v < height - reach):
        return None
    patch = grey[v - reach : v + reach + 1, u - reach : u + reach + 1].astype(np.float32)
    dark, bright = np.percentile(patch, (10, 90))
    across, down = (cv2.Sobel(patch, cv2.CV_32F, *order, scale=1 / 8) for order in ((1, 0), (0, 1)))
    slope = float(np.percentile(np.hypot(across, down), 98))
    return slope / max(float(bright - dark), 1.0)

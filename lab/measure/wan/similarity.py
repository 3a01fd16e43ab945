"""How alike two pictures are: the mean structural similarity; pure."""

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array

WINDOW, SIGMA = (11, 11), 1.5
C1, C2 = (0.01 * 255) ** 2, (0.03 * 255) ** 2


def ssim(one: Image, other: Image) -> float:
    """The mean SSIM of the brightness of two BGR pictures of one size, 1 where they are the same.

    Wang, Bovik, Sheikh, Simoncelli: Image quality assessment, IEEE Trans. Image Processing 13 (2004), with the
    authors' Gaussian window of 11 x 11 and their constants.
    """
    x, y = (cv2.cvtColor(image, cv2.COLOR_BGR2GRAY).astype(np.float64) for image in (one, other))
    mean_x, mean_y = _smooth(x), _smooth(y)
    var_x, var_y = _smooth(x * x) - mean_x**2, _smooth(y * y) - mean_y**2
    covariance = _smooth(x * y) - mean_x * mean_y
    likeness = (2 * mean_x * mean_y + C1) * (2 * covariance + C2)
    return float(np.mean(likeness / ((mean_x**2 + mean_y**2 + C1) * (var_x + var_y + C2))))


def _smooth(values: Array) -> Array:
    return np.asarray(cv2.GaussianBlur(values, WINDOW, SIGMA))

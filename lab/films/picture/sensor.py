"""Effects of a lens and a sensor on a picture: a little blur, noise, whole grey levels."""

import cv2
import numpy as np
from numpy.random import Generator

from common.cameras.camera import Image
from lab.films.picture.rendering import Picture

FOCUS_SIGMA_PX = 0.55
NOISE_MARGIN_PX = 61  # every picture shows another part of one larger picture of noise


class Sensor:
    """The sensor of cameras with pictures of one size (width, height) and noise of one strength in grey levels."""

    def __init__(self, size: tuple[int, int], noise: float, random: Generator) -> None:
        self._random = random
        shape = (size[1] + NOISE_MARGIN_PX, size[0] + NOISE_MARGIN_PX, 3)
        self._noise = np.rint(random.normal(0.0, noise, shape)).astype(np.int16)

    def exposed(self, picture: Picture) -> Image:
        """The picture (H, W, 3) as it is read out."""
        soft = cv2.GaussianBlur(cv2.convertScaleAbs(picture), (3, 3), FOCUS_SIGMA_PX)
        height, width = soft.shape[:2]
        top, left = self._random.integers(0, NOISE_MARGIN_PX, 2)
        noise = self._noise[top : top + height, left : left + width]
        return np.asarray(cv2.add(soft, noise, dtype=cv2.CV_8U), dtype=np.uint8)

"""Pictures as a pinhole camera would have taken them, whole or only where they are looked at."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from local_site.calibration.physical_camera import Lens

Maps = tuple[cv2.typing.MatLike, cv2.typing.MatLike]
Pixels = NDArray[np.int32]
EVERYTHING = slice(None)


class Undistorter:
    """Undistorts the pictures of one camera; the maps are computed once for each size of picture."""

    def __init__(self, lens: Lens | None, border: int) -> None:
        """`border` is how OpenCV fills pixels from outside the picture."""
        self._lens, self._border = lens, border
        self._maps: Maps | None = None

    def undistorted(self, picture: Image, rows: slice = EVERYTHING, columns: slice = EVERYTHING) -> Image:
        """The part of the picture, (H, W) or (H, W, 3), that a pinhole camera with the same matrix would have taken."""
        maps = self._maps_for(picture)
        if maps is None:
            return picture[rows, columns]
        part = maps[0][rows, columns], maps[1][rows, columns]
        return np.asarray(cv2.remap(picture, *part, cv2.INTER_LINEAR, borderMode=self._border), dtype=np.uint8)

    def nearest(self, picture: Image, pixels: Pixels) -> Image:
        """The values (N, ...) of the pixels taken next to undistorted ones (N, 2), inside the picture."""
        x, y = pixels.T
        maps = self._maps_for(picture)
        if maps is not None:
            x, y = np.asarray(maps[0])[y, x].T
            x, y = np.clip(x, 0, picture.shape[1] - 1), np.clip(y, 0, picture.shape[0] - 1)
        return np.asarray(picture[y, x], dtype=np.uint8)

    def _maps_for(self, picture: Image) -> Maps | None:
        if self._lens is None or not self._lens.is_distorted:
            return None
        if self._maps is None or self._maps[0].shape[:2] != picture.shape[:2]:
            matrix, distortion = self._lens.matrix, np.array([self._lens.k1, self._lens.k2, 0.0, 0.0])
            size = picture.shape[1], picture.shape[0]
            self._maps = cv2.initUndistortRectifyMap(matrix, distortion, np.eye(3), matrix, size, cv2.CV_16SC2)
        return self._maps


class TakenPicture:
    """A picture in colour as the camera took it, undistorted only where it is looked at: the whole takes long."""

    def __init__(self, taken: Image, undistorter: Undistorter) -> None:
        """`taken` is (H, W, 3)."""
        self._taken, self._undistorter = taken, undistorter
        self.shape = taken.shape[0], taken.shape[1]

    def part(self, rows: slice = EVERYTHING, columns: slice = EVERYTHING) -> Image:
        """A part of the undistorted picture."""
        return self._undistorter.undistorted(self._taken, rows, columns)

    def at(self, pixels: Pixels) -> Image:
        """Colours (N, 3) near undistorted pixels (N, 2)."""
        return self._undistorter.nearest(self._taken, pixels)

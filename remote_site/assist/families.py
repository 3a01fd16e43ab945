"""The families of square markers that can be printed and found."""

from collections.abc import Sequence
from enum import StrEnum

import cv2
import numpy as np

from common.cameras.camera import Image


class MarkerFamily(StrEnum):
    """A family of markers by the name that configurations use."""

    ARUCO_4X4_50 = "aruco_4x4_50"
    ARUCO_5X5_100 = "aruco_5x5_100"
    ARUCO_6X6_250 = "aruco_6x6_250"
    APRILTAG_25H9 = "apriltag_25h9"
    APRILTAG_36H11 = "apriltag_36h11"

    @property
    def dictionary(self) -> cv2.aruco.Dictionary:
        """OpenCV's table of the family."""
        return cv2.aruco.getPredefinedDictionary(DICTIONARIES[self])

    def part(self, markers: Sequence[int]) -> cv2.aruco.Dictionary:
        """OpenCV's table of these markers alone, by their places here: other squares take less time."""
        whole = self.dictionary
        return cv2.aruco.Dictionary(whole.bytesList[list(markers)], whole.markerSize, whole.maxCorrectionBits)

    @property
    def size(self) -> int:
        """Return how many markers the family has; their numbers begin at 0."""
        return len(self.dictionary.bytesList)

    def printed(self, marker: int, module_px: int, quiet: int = 1) -> Image:
        """A marker (n, n), black on white, with `quiet` white modules around it."""
        modules = self.dictionary.markerSize + 2
        square = cv2.aruco.generateImageMarker(self.dictionary, marker, modules * module_px)
        margin = quiet * module_px
        return np.asarray(cv2.copyMakeBorder(square, *(margin,) * 4, cv2.BORDER_CONSTANT, value=255), dtype=np.uint8)


DICTIONARIES = {
    MarkerFamily.ARUCO_4X4_50: cv2.aruco.DICT_4X4_50,
    MarkerFamily.ARUCO_5X5_100: cv2.aruco.DICT_5X5_100,
    MarkerFamily.ARUCO_6X6_250: cv2.aruco.DICT_6X6_250,
    MarkerFamily.APRILTAG_25H9: cv2.aruco.DICT_APRILTAG_25H9,
    MarkerFamily.APRILTAG_36H11: cv2.aruco.DICT_APRILTAG_36H11,
}

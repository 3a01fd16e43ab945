"""Finds the markers of a family in a picture, their corners to a fraction of a pixel; pure."""

from collections.abc import Iterable

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from remote_site.assist.families import MarkerFamily

LEAST_PERIMETER = 0.06  # of the picture's larger side: what is smaller is known too poorly
WINDOW_PX = 15
MODULE_PX = 8  # of the print that a picture is compared with
QUIET = 0.75  # of the white module around a marker is compared: behind it is anything
BLUR_PX = 0.6  # how far a sharp camera smears an edge, as a standard deviation
LEAST_LIKENESS = 0.9  # a print that is partly covered or blurred is less like its marker
STEPS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-5)

Corners = dict[int, list[Array]]


class MarkerDetector:
    """Finds the corners of some markers of a family; others of the family are ignored.

    The whole print is compared with the picture: its edges show where it is ten times better than its corners alone.
    """

    def __init__(self, family: MarkerFamily, markers: Iterable[int]) -> None:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = WINDOW_PX
        parameters.minMarkerPerimeterRate = LEAST_PERIMETER
        self._detector = cv2.aruco.ArucoDetector(family.dictionary, parameters)
        self._prints = {marker: family.printed(marker, MODULE_PX) for marker in markers}

    def find(self, picture: Image) -> Corners:
        """By number, the corners (4, 2) of each such marker in the picture: pixels from its upper left corner.

        They run clockwise from the marker's own upper left. A number that is there twice has two entries; one that is
        covered in part is not there.
        """
        grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if picture.ndim == 3 else picture, dtype=np.uint8)
        rough, numbers, _ = self._detector.detectMarkers(grey)
        found: Corners = {}
        for number, four in zip([] if numbers is None else map(int, np.ravel(numbers)), rough, strict=True):
            corners = self._refined(grey, number, np.reshape(four, (4, 2)).astype(np.float32))
            if corners is not None:
                found.setdefault(number, []).append(corners)
        return found

    def _refined(self, grey: Image, number: int, rough: Image) -> Array | None:
        """The corners where the print fits the picture best; None for another marker, or one that does not fit."""
        if number not in self._prints:
            return None
        length_px = cv2.arcLength(rough, closed=True) / 4
        cut = round((1.0 - QUIET) * MODULE_PX)
        whole = self._prints[number]
        modules = len(whole) / MODULE_PX - 2
        smeared = cv2.GaussianBlur(whole, (0, 0), BLUR_PX * modules * MODULE_PX / length_px)
        template = np.ascontiguousarray(smeared[cut:-cut, cut:-cut])
        low, high = MODULE_PX - cut - 0.5, len(template) - MODULE_PX + cut - 0.5
        square = np.array([(low, low), (high, low), (high, high), (low, high)], dtype=np.float32)
        start = cv2.getPerspectiveTransform(square, rough).astype(np.float32)
        try:
            everywhere = np.full_like(grey, 255)
            likeness, warp = cv2.findTransformECC(template, grey, start, cv2.MOTION_HOMOGRAPHY, STEPS, everywhere, 1)
        except cv2.error:  # it does not converge
            return None
        if likeness < LEAST_LIKENESS:
            return None
        return np.asarray(cv2.perspectiveTransform(square[None], warp)[0] + 0.5, dtype=float)

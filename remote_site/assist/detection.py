"""Finds the markers of a family in a picture, their corners to a fraction of a pixel; pure."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

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

MOST_REFINED = 2  # of a number: two are one too many already
ROOM, ROOM_PX = 0.4, 8  # around what is cut out for it: two modules, and how far rough corners may be off

Corners = dict[int, list[Array]]


class FoundMarkers(NamedTuple):
    """By number, the corners (4, 2) of each marker in a picture; `unreached` numbers may be there, and be anywhere."""

    corners: Corners
    unreached: tuple[int, ...] = ()


class MarkerDetector:
    """Finds the corners of some markers of a family; others of the family are ignored.

    The whole print is compared with the picture: its edges show where it is ten times better than its corners alone.
    """

    def __init__(self, family: MarkerFamily, markers: Iterable[int]) -> None:
        parameters = cv2.aruco.DetectorParameters()
        parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_NONE
        parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = WINDOW_PX
        parameters.minMarkerPerimeterRate = LEAST_PERIMETER
        self._numbers = tuple(markers)
        self._detector = cv2.aruco.ArucoDetector(family.part(self._numbers), parameters)
        self._prints = {marker: family.printed(marker, MODULE_PX) for marker in self._numbers}

    def find(
        self, picture: Image, has_time: Callable[[], bool] = lambda: True, first: Sequence[int] = ()
    ) -> FoundMarkers:
        """The corners of each such marker in the picture, pixels from its upper left corner.

        They run clockwise from the marker's own upper left. A number that is there twice has two entries; of one that
        is there more often the entries are not exact. One that is covered in part is not there. Numbers that are not
        looked at before `has_time` ends are named; those of `first` come first, in this order.
        """
        grey = np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) if picture.ndim == 3 else picture, dtype=np.uint8)
        corners: Corners = {}
        unreached: list[int] = []
        rough = self._rough(grey)
        for number in sorted(rough, key=lambda seen: first.index(seen) if seen in first else len(first)):
            places = rough[number]
            if len(places) > MOST_REFINED:
                corners[number] = places
            elif not has_time():
                unreached.append(number)
            elif exact := [four for place in places if (four := self._refined(grey, number, place)) is not None]:
                corners[number] = exact
        return FoundMarkers(corners, tuple(unreached))

    def _rough(self, grey: Image) -> Corners:
        """The corners to a pixel or two."""
        rough, places, _ = self._detector.detectMarkers(grey)
        found: Corners = {}
        for place, four in zip([] if places is None else map(int, np.ravel(places)), rough, strict=True):
            found.setdefault(self._numbers[place], []).append(np.reshape(four, (4, 2)).astype(float))
        return found

    def _refined(self, grey: Image, number: int, rough: Array) -> Array | None:
        """The corners where the print fits the picture best; None where it does not fit."""
        length_px = cv2.arcLength(rough.astype(np.float32), closed=True) / 4
        cut = round((1.0 - QUIET) * MODULE_PX)
        whole = self._prints[number]
        modules = len(whole) / MODULE_PX - 2
        smeared = cv2.GaussianBlur(whole, (0, 0), BLUR_PX * modules * MODULE_PX / length_px)
        template = np.ascontiguousarray(smeared[cut:-cut, cut:-cut])
        low, high = MODULE_PX - cut - 0.5, len(template) - MODULE_PX + cut - 0.5
        square = np.array([(low, low), (high, low), (high, high), (low, high)], dtype=np.float32)
        around, corner = _cut_out(grey, rough)
        start = cv2.getPerspectiveTransform(square, (rough - corner).astype(np.float32)).astype(np.float32)
        try:
            everywhere = np.full_like(around, 255)
            likeness, warp = cv2.findTransformECC(template, around, start, cv2.MOTION_HOMOGRAPHY, STEPS, everywhere, 1)
        except cv2.error:  # it does not converge
            return None
        if likeness < LEAST_LIKENESS:
            return None
        return np.asarray(cv2.perspectiveTransform(square[None], warp)[0] + 0.5, dtype=float) + corner


def _cut_out(grey: Image, rough: Array) -> tuple[Image, Array]:
    """A marker with room around it, and the pixel (2,) where that begins."""
    low, high = rough.min(axis=0), rough.max(axis=0)
    room = ROOM * (high - low).max() + ROOM_PX
    left, top = np.maximum(np.floor(low - room), 0).astype(int)
    right, bottom = np.ceil(high + room).astype(int) + 1
    return np.ascontiguousarray(grey[top:bottom, left:right]), np.array([left, top], dtype=float)

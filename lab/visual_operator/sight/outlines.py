"""The outline of a coloured thing in a picture as its support function: how far it reaches in each direction."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from lab.visual_operator.sight.colours import colour_above

FINER = 4  # the outline is found between pixels
LEAST_PX = 12  # a smaller spot is no thing
EDGE_PX = 1.5
TINY = 1e-9
DIRECTIONS = 24
ANGLES = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
UNITS: Array = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])  # (DIRECTIONS, 2)


class Box(NamedTuple):
    """A part of a picture, px."""

    x: int
    y: int
    width: int
    height: int

    def wider(self, by: int, picture: Image) -> "Box":
        """The box with a margin, as far as the picture goes."""
        height, width = picture.shape[:2]
        x, y = max(self.x - by, 0), max(self.y - by, 0)
        return Box(x, y, min(self.x + self.width + by, width) - x, min(self.y + self.height + by, height) - y)

    def around(self, other: "Box") -> "Box":
        """The least box that holds both."""
        x, y = min(self.x, other.x), min(self.y, other.y)
        right, bottom = (
            max(self.x + self.width, other.x + other.width),
            max(self.y + self.height, other.y + other.height),
        )
        return Box(x, y, right - x, bottom - y)

    def touches(self, other: "Box", within: int) -> bool:
        """Return whether two boxes overlap, or nearly."""
        apart_x = max(self.x - other.x - other.width, other.x - self.x - self.width)
        apart_y = max(self.y - other.y - other.height, other.y - self.y - self.height)
        return max(apart_x, apart_y) <= within


@dataclass(frozen=True, slots=True)
class Outline:
    """The convex hull of a thing: its reach in each of `UNITS`, px from the picture's upper left corner.

    A reach is NaN where the picture ends. `centre` (2,) is the middle of the thing, `area` its size in px.
    """

    reach: Array
    centre: Array
    area: float


def spots(picture: Image, colour: str) -> list[tuple[float, Box]]:
    """The connected regions of a colour, largest first: area, px, and box."""
    mask = (colour_above(picture, colour) > 0.0).astype(np.uint8)
    left, top, width, height = cv2.boundingRect(mask)
    if not width:
        return []
    part = mask[top : top + height, left : left + width]
    count, _, stats, _ = cv2.connectedComponentsWithStatsWithAlgorithm(part, 8, cv2.CV_32S, cv2.CCL_BOLELLI)
    found = [(float(area), Box(x + left, y + top, wide, high)) for x, y, wide, high, area in stats[1:count].tolist()]
    return sorted((spot for spot in found if spot[0] >= LEAST_PX), reverse=True)


def outline(above: Array, corner: tuple[int, int], size: tuple[int, int]) -> Outline | None:
    """The hull of all regions where `above`, of the part at `corner` of a picture of `size` (H, W), is positive.

    None without any.
    """
    height, width = size
    fine = cv2.resize(above, None, fx=FINER, fy=FINER, interpolation=cv2.INTER_LINEAR)
    contours, _ = cv2.findContours((fine > 0).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    areas = [cv2.contourArea(contour) / FINER**2 for contour in contours]
    chosen = [k for k, area in enumerate(areas) if area >= LEAST_PX]
    if not chosen:
        return None
    points = np.concatenate([contours[k][:, 0] for k in chosen]).astype(float)
    points = (points + 0.5) / FINER + corner
    reach = (points @ UNITS.T).max(axis=0)
    reach[_ends(points, width, height)] = np.nan
    return Outline(reach, (points.min(axis=0) + points.max(axis=0)) / 2, sum(areas[k] for k in chosen))


def _ends(points: Array, width: int, height: int) -> Array:
    """Which directions (DIRECTIONS,) lead over an edge of the picture that the thing touches."""
    low, high = points.min(axis=0) < EDGE_PX, points.max(axis=0) > np.array([width, height]) - EDGE_PX
    return np.asarray(((UNITS < -TINY) & low).any(axis=1) | ((UNITS > TINY) & high).any(axis=1))

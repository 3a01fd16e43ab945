"""The colour of block, gripper or target in a view, with the part of the picture that holds it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np

from common.geometry import Array
from lab.visual_operator.shown import ShownView
from lab.visual_operator.sight.colours import colour_above
from lab.visual_operator.sight.edge_fit import project
from lab.visual_operator.sight.outlines import Box, spots
from lab.visual_operator.task import PlacingTask

AROUND_PX = 8
MARK_PX = 5
HIDDEN_PX = 9
NOTHING = -1.0
PAPER_AREA_PX = (60.0, 3000.0)
BESIDE_PX = 3
LEAST_PART = 0.3


@dataclass(frozen=True, slots=True)
class ColouredThing:
    """By how much each pixel of a part of a picture is above a thing's colour (H, W); the part begins at `corner`.

    `luma` (H, W) is its brightness, `size` (height, width) the whole picture's; `projection` (3, 4) is the view's, from
    the base's frame or the tool's.
    """

    above: Array
    luma: Array
    corner: tuple[int, int]
    size: tuple[int, int]
    projection: Array

    @property
    def box(self) -> Array:
        """The upper left and the lower right corner (2, 2) of what has the colour, px."""
        y, x = np.nonzero(self.above > 0)
        return np.array([(x.min(), y.min()), (x.max() + 1, y.max() + 1)]) + self.corner


class ColouredBlock(NamedTuple):
    """The block in a view, and the stripe on it."""

    block: ColouredThing
    stripe: ColouredThing


def coloured_block(view: ShownView, marks: Array | None, before_it: Sequence[Array] = ()) -> ColouredBlock | None:
    """The blue, and the red of the stripe on it; the target's marks (3, 3) on the table are left out.

    What stands `before_it`, the corners (N, 3) of convex shapes, hides where the colours end: they are NaN there.
    """
    blues = [box for _, box in spots(view.picture, "blue")[:2]]
    if not blues:
        return None
    split = len(blues) == 2 and blues[0].touches(blues[1], AROUND_PX)  # by the stripe
    part = _Part(view, blues[0].around(blues[1]) if split else blues[0])
    red = part.above("red")
    if marks is not None:
        corners = project(view.projection, marks) - part.box[:2]
        cv2.polylines(red, [corners.round().astype(np.int32)], isClosed=False, color=NOTHING, thickness=MARK_PX)
    block = np.maximum(part.above("blue"), red)
    for shape in before_it:
        hull = cv2.convexHull((project(view.projection, shape) - part.box[:2]).round().astype(np.int32))
        hidden = cv2.fillConvexPoly(np.zeros(block.shape, np.uint8), hull, 1)
        block[cv2.dilate(hidden, np.ones((HIDDEN_PX, HIDDEN_PX), np.uint8)) > 0] = np.nan
    return ColouredBlock(part.thing(block), part.thing(red))


def coloured_fingers(view: ShownView) -> ColouredThing | None:
    """The orange of both fingers."""
    boxes = [box for _, box in spots(view.picture, "orange")[:2]]
    if not boxes:
        return None
    part = _Part(view, boxes[0].around(boxes[-1]))
    return part.thing(part.above("orange"))


def finger_spots(view: ShownView) -> list[ColouredThing]:
    """The orange spots of a view, two at most: the fingers, where a view shows them apart."""
    largest = spots(view.picture, "orange")[:2]
    apart = (
        len(largest) == 2 and largest[1][0] > LEAST_PART * largest[0][0] and not largest[0][1].touches(largest[1][1], 3)
    )
    parts = [_Part(view, box) for _, box in (largest if apart else largest[:1])]
    things = []
    for k, part in enumerate(parts):
        above = part.above("orange")
        if len(parts) == 2:
            other = parts[1 - k].spot
            x, y = other.x - part.box.x, other.y - part.box.y
            above[max(y - 2, 0) : max(y + other.height + 2, 0), max(x - 2, 0) : max(x + other.width + 2, 0)] = NOTHING
        things.append(part.thing(above))
    return things


def coloured_paper(view: ShownView, corners: Array) -> ColouredThing | None:
    """The white about the target's corners (4, 3); None where there is little of it."""
    pixels = project(view.projection, corners)
    (x, y), (right, bottom) = pixels.min(axis=0).astype(int).tolist(), pixels.max(axis=0).astype(int).tolist()
    part = _Part(view, Box(x, y, right - x, bottom - y))
    above = part.above("white")
    return part.thing(above) if (above > 0).sum() > PAPER_AREA_PX[0] else None


def papers_in(view: ShownView, task: PlacingTask) -> list[Array]:
    """The points of the table (3,) where the corner of a white region of the target's size, beside red, may be."""
    reds = [box for _, box in spots(view.picture, "red")]
    half = task.target_side / 2
    places = []
    for area, box in spots(view.picture, "white"):
        if PAPER_AREA_PX[0] < area < PAPER_AREA_PX[1] and any(box.touches(red, BESIDE_PX) for red in reds):
            middle = on_plane(view.projection, (box.x + box.width / 2, box.y + box.height / 2), task.table_z)
            places.append(middle + np.array([half, -half, 0.0]))
    return places


def on_plane(projection: Array, pixel: tuple[float, float], z: float) -> Array:
    """The point (3,) at a height z that a view (3 x 4) shows at a pixel."""
    a, b, c, d = projection.T
    x, y, w = np.linalg.solve(np.column_stack([a, b, c * z + d]), np.array([*pixel, 1.0]))
    return np.array([x / w, y / w, z])


class _Part:
    """The part of a view's picture around a box."""

    def __init__(self, view: ShownView, box: Box) -> None:
        self._view, self.spot = view, box
        self.box = box.wider(AROUND_PX, view.picture)

    def above(self, colour: str) -> Array:
        x, y, width, height = self.box
        return colour_above(self._view.picture[y : y + height, x : x + width], colour)

    def thing(self, above: Array) -> ColouredThing:
        height, width = self._view.picture.shape[:2]
        x, y, w, h = self.box
        luma: Array = np.array(cv2.cvtColor(self._view.picture[y : y + h, x : x + w], cv2.COLOR_BGR2GRAY), np.float32)
        return ColouredThing(above, luma, (self.box.x, self.box.y), (height, width), self._view.projection)

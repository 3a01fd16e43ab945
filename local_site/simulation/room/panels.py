"""Flat pictures in space as a camera sees them: walls, floors, and what stands before them."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.cameras import PinholeCamera

LENS_STEPS = 8


@dataclass(frozen=True, slots=True)
class Panel:
    """A picture (H, W, 4) BGR and cover, 0 to 255, of `px_per_m`, on a plane of the operator frame.

    `corner` (3,) is its upper left in m, `across` and `down` (3,) are unit vectors along its rows and columns.
    """

    picture: Image
    px_per_m: float
    corner: Array
    across: Array
    down: Array


def lines_of_sight(camera: PinholeCamera, size: tuple[int, int]) -> Array:
    """The direction (H, W, 3) in the operator frame into which each pixel looks."""
    grid = np.stack(np.meshgrid(np.arange(float(size[0])), np.arange(float(size[1]))), axis=-1)
    distorted = (grid - camera.principal_px) / camera.focal_px
    slopes = distorted
    for _ in range(LENS_STEPS if camera.k1 else 0):
        slopes = distorted / (1.0 + camera.k1 * np.sum(slopes * slopes, axis=-1, keepdims=True))
    sight: Array = np.concatenate([slopes, np.ones((*slopes.shape[:2], 1))], axis=-1) @ camera.camera_R_operator
    return sight


def film(panels: Iterable[Panel], centre: Array, sight: Array) -> Image:
    """The picture (H, W, 3) BGR of panels, the farthest first, from a camera at `centre` (3,) in m."""
    picture = np.zeros(sight.shape, np.float32)
    for panel in panels:
        seen = _seen(panel, centre, sight)
        left, top, width, height = cv2.boundingRect(seen[:, :, 3])
        box = slice(top, top + height), slice(left, left + width)
        cover = seen[box][:, :, 3:].astype(np.float32) / np.float32(255.0)
        picture[box] += cover * (seen[box][:, :, :3] - picture[box])
    return picture.round().astype(np.uint8)


def _seen(panel: Panel, centre: Array, sight: Array) -> Image:
    """The panel alone (H, W, 4), with no cover where it is not to be seen."""
    # A frame without cover keeps the panel's edge smooth and its colour.
    framed = cv2.copyMakeBorder(panel.picture, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    framed[[0, -1], :, 3] = framed[:, [0, -1], 3] = 0
    normal = np.cross(panel.across, panel.down)
    approach = sight @ normal
    distance = (panel.corner - centre) @ normal / np.where(np.abs(approach) < 1e-9, 1e-9, approach)
    from_corner = centre - panel.corner
    row, column = (
        np.where(distance > 0.0, panel.px_per_m * (from_corner @ axis + distance * (sight @ axis)) + 0.5, -10.0).astype(
            np.float32
        )
        for axis in (panel.down, panel.across)
    )
    seen = cv2.remap(framed, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return np.asarray(seen, dtype=np.uint8)

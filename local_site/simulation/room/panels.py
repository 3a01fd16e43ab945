"""Flat pictures in space as a camera sees them: walls, floors, and what stands before them."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.calibration.physical_camera import PhysicalCamera
from local_site.simulation.cameras import PinholeCamera

DEFOCUS = 0.0016  # sigma of the blur behind the operator, of the picture's width
BEHIND_PX = -10.0


@dataclass(frozen=True, slots=True)
class Plane:
    """The place of a picture of `px_per_m` in the operator frame.

    `corner` (3,) is its upper left in m, `across` and `down` (3,) are unit vectors along its rows and columns.
    """

    px_per_m: float
    corner: Array
    across: Array
    down: Array

    def met(self, centre: Array, sight: Array) -> tuple[Array, Array]:
        """Return how far (H, W) along lines of `sight` (H, W, 3) from `centre` (3,) in m it lies, and its px (H, W, 2)
        there; BEHIND_PX where it lies behind."""
        normal, from_corner = np.cross(self.across, self.down), centre - self.corner
        approach = sight @ normal
        distance = -from_corner @ normal / np.where(np.abs(approach) < 1e-9, 1e-9, approach)
        pixels = [
            np.where(distance > 0.0, self.px_per_m * (from_corner @ axis + distance * (sight @ axis)), BEHIND_PX)
            for axis in (self.across, self.down)
        ]
        return distance, np.stack(pixels, axis=-1)


@dataclass(frozen=True, slots=True)
class Panel:
    """A picture (H, W, 4) BGR and cover, 0 to 255, on its plane."""

    picture: Image
    plane: Plane


def lines_of_sight(camera: PhysicalCamera, size: tuple[int, int]) -> Array:
    """The direction (H, W, 3) in the operator frame into which each pixel looks."""
    lens = camera.lens
    grid = np.stack(np.meshgrid(np.arange(float(size[0])), np.arange(float(size[1]))), axis=-1)
    slopes = (lens.undistort_pixels(grid) - (lens.cx, lens.cy)) / (lens.fx, lens.fy)
    sight: Array = np.concatenate([slopes, np.ones((*slopes.shape[:2], 1))], axis=-1) @ camera.camera_R_operator
    return sight


def film(panels: Iterable[Panel], camera: PinholeCamera, size: tuple[int, int]) -> Image:
    """The picture (H, W, 3) BGR of panels, the farthest first, that a camera takes of `size` (W, H), out of focus."""
    sight = lines_of_sight(camera.physical, size)
    picture = np.zeros(sight.shape, np.float32)
    for panel in panels:
        seen = _seen(panel, camera.centre, sight)
        left, top, width, height = cv2.boundingRect(seen[:, :, 3])
        box = slice(top, top + height), slice(left, left + width)
        cover = seen[box][:, :, 3:].astype(np.float32) / np.float32(255.0)
        picture[box] += cover * (seen[box][:, :, :3] - picture[box])
    return out_of_focus(picture.round().astype(np.uint8))


def out_of_focus(picture: Image) -> Image:
    """A picture (H, W, 3) of what lies behind the operator, on whom the lens is focused."""
    return np.asarray(cv2.GaussianBlur(picture, (0, 0), DEFOCUS * picture.shape[1]), dtype=np.uint8)


def _seen(panel: Panel, centre: Array, sight: Array) -> Image:
    """The panel alone (H, W, 4), with no cover where it is not to be seen."""
    # A frame without cover keeps the panel's edge smooth and its colour.
    framed = cv2.copyMakeBorder(panel.picture, 1, 1, 1, 1, cv2.BORDER_REPLICATE)
    framed[[0, -1], :, 3] = framed[:, [0, -1], 3] = 0
    pixels = (panel.plane.met(centre, sight)[1] + 0.5).astype(np.float32)
    column, row = pixels[..., 0], pixels[..., 1]
    seen = cv2.remap(framed, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    return np.asarray(seen, dtype=np.uint8)

"""The outline of the simulated arm in a picture: exact, since a hull of balls projects to the hull of their outlines."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.simulation.body import RIM_POINTS, Part, Solid
from local_site.simulation.cameras import PinholeCamera

Polygon = NDArray[np.float32]

_TURN = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
# Half way between inscribed and circumscribed, so that a polygon of few corners is as wide as its circle on average.
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)]) * (0.5 + 0.5 / np.cos(np.pi / RIM_POINTS))


@dataclass(frozen=True, slots=True)
class PartOutline:
    """A limb in the picture: convex polygons (K, 2) in px whose union is its silhouette; `depth` in m from the camera."""

    name: str
    polygons: tuple[Polygon, ...]
    depth: float


def part_outlines(
    solid: Solid, parts: tuple[Part, ...], camera: PinholeCamera, inset_px: float = 0.0
) -> list[PartOutline]:
    """The limbs as this camera sees them, the farthest first, each smaller all round by `inset_px`."""
    centres = camera.to_camera(solid.centres)
    radii = solid.radii - inset_px / camera.focal_px * centres[:, 2]
    rims = np.concatenate([_ball_outlines(centres, radii), camera.to_camera(solid.rim)[None]])
    pixels = camera.pixels(rims).astype(np.float32)
    depths = np.append(centres[:, 2], camera.to_camera(solid.rim.mean(axis=0))[2])
    outlines = [_part_outline(part, pixels, depths) for part in parts]
    return sorted(outlines, key=lambda outline: -outline.depth)


def _part_outline(part: Part, pixels: Polygon, depths: Array) -> PartOutline:
    polygons = tuple(cv2.convexHull(pixels[list(piece)].reshape(-1, 2))[:, 0] for piece in part.pieces)
    return PartOutline(part.name, polygons, float(np.mean([depths[list(piece)].mean() for piece in part.pieces])))


def _ball_outlines(centres: Array, radii: Array) -> Array:
    """The circles (N, RIM_POINTS, 3) along which lines of sight touch the balls, in the camera's frame."""
    distance2 = np.sum(centres * centres, axis=1)
    shrink = 1.0 - radii * radii / distance2
    sight = centres / np.sqrt(distance2)[:, None]
    side = np.column_stack([sight[:, 2], np.zeros(len(sight)), -sight[:, 0]])
    side /= np.sqrt(np.sum(side * side, axis=1, keepdims=True))
    radius = (radii * np.sqrt(shrink))[:, None, None]
    around = _CIRCLE[:, :1] * side[:, None] + _CIRCLE[:, 1:] * np.cross(sight, side)[:, None]
    return shrink[:, None, None] * centres[:, None] + radius * around

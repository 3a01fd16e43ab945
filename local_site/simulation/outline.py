"""The outline of the simulated arm in a picture, exact: a hull of balls projects to the hull of their outlines."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.simulation.body import RIM_POINTS, Part, Solid
from local_site.simulation.cameras import PinholeCamera

FixedPoints = NDArray[np.int32]

_TURN = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
# Half way between inscribed and circumscribed, so that a polygon of few corners is as wide as its circle on average.
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)]) * (0.5 + 0.5 / np.cos(np.pi / RIM_POINTS))


@dataclass(frozen=True, slots=True)
class Outlines:
    """What the lens makes of the balls: `rims` (N + 1, RIM_POINTS, 2) in px, the sleeve's rim last.

    `depths` (N + 1,) are the distances of their centres along the line of sight, m.
    """

    rims: Array
    depths: Array

    def extent(self) -> tuple[Array, Array]:
        """The least and the greatest pixel coordinates, (2,) each."""
        u, v = self.rims[..., 0], self.rims[..., 1]
        return np.array([u.min(), v.min()]), np.array([u.max(), v.max()])


def project(solid: Solid, camera: PinholeCamera, inset_px: float = 0.0) -> Outlines:
    """The outlines of all balls in one camera, each smaller all round by `inset_px`."""
    centres = camera.to_camera(solid.centres)
    radii = solid.radii - inset_px / camera.focal_px * centres[:, 2]
    rim = camera.to_camera(solid.rim)
    rims = camera.pixels(np.concatenate([_ball_outlines(centres, radii), rim[None]]))
    return Outlines(rims, np.append(centres[:, 2], rim[:, 2].mean()))


def part_polygons(rims: FixedPoints, depths: Array, parts: tuple[Part, ...]) -> list[list[FixedPoints]]:
    """Each part's convex polygons, whose union is its silhouette; the farthest part first."""
    order = sorted(parts, key=lambda part: -depths[part.balls].mean())
    return [[_hull(rims[piece].reshape(-1, 2)) for piece in part.pieces] for part in order]


def _hull(points: FixedPoints) -> FixedPoints:
    return cv2.convexHull(points).astype(np.int32, copy=False)


def _ball_outlines(centres: Array, radii: Array) -> Array:
    """The circles (N, RIM_POINTS, 3) along which lines of sight touch the balls, in the camera's frame."""
    distance2 = np.sum(centres * centres, axis=1)
    shrink = 1.0 - radii * radii / distance2
    sight = centres / np.sqrt(distance2)[:, None]
    x, y, z = sight.T
    # Two axes across the line of sight: (z, 0, -x) and its cross product with the sight. No ball is seen at z = 0.
    across = np.stack([z, np.zeros_like(z), -x, -x * y, x * x + z * z, -y * z], axis=1).reshape(-1, 2, 3)
    axes = (radii * np.sqrt(shrink / (x * x + z * z)))[:, None, None] * across
    touching: Array = shrink[:, None, None] * centres[:, None] + _CIRCLE @ axes
    return touching

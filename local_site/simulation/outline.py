"""The outline of the simulated arm in a picture, exact: a hull of balls projects to the hull of their outlines."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.simulation.body import RIM_POINTS, Part, Solid
from local_site.simulation.cameras import PinholeCamera

FixedPoints = NDArray[np.int32]

JUST_M = 1e-6
_TURN = np.linspace(0.0, 2.0 * np.pi, RIM_POINTS, endpoint=False)
# Half way between inscribed and circumscribed, so that a polygon of few corners is as wide as its circle on average.
_CIRCLE = np.column_stack([np.cos(_TURN), np.sin(_TURN)]) * (0.5 + 0.5 / np.cos(np.pi / RIM_POINTS))


@dataclass(frozen=True, slots=True)
class Outlines:
    """What the lens makes of N balls, the sleeve's rim and K markers: `rims` (N + 1 + K, RIM_POINTS, 2) in px.

    `depths` (N + 1 + K,) are the distances of their centres along the line of sight, m.
    """

    rims: Array
    depths: Array

    def extent(self) -> tuple[Array, Array]:
        """The least and the greatest pixel coordinates, (2,) each."""
        u, v = self.rims[..., 0], self.rims[..., 1]
        return np.array([u.min(), v.min()]), np.array([u.max(), v.max()])


def project(solid: Solid, camera: PinholeCamera, inset_px: float = 0.0) -> Outlines:
    """The outlines of all balls in one camera, each smaller all round by `inset_px`."""
    count = len(solid.radii)
    centres = camera.to_camera(np.concatenate([solid.centres, solid.markers]))
    full = np.concatenate([solid.radii, np.full(len(solid.markers), solid.marker_radius)])
    balls = _ball_outlines(centres, full - inset_px / camera.focal_px * centres[:, 2])
    rim = camera.to_camera(solid.rim)
    rims = camera.pixels(np.concatenate([balls[:count], rim[None], balls[count:]]))
    return Outlines(rims, np.insert(centres[:, 2], count, rim[:, 2].mean()))


def part_polygons(rims: FixedPoints, depths: Array, parts: tuple[Part, ...]) -> list[list[FixedPoints]]:
    """Each part's convex polygons, whose union is its silhouette, in the order of `farthest_first`."""
    return [[_hull(rims[piece].reshape(-1, 2)) for piece in part.pieces] for part in farthest_first(depths, parts)]


def farthest_first(depths: Array, parts: tuple[Part, ...]) -> list[Part]:
    """The parts in the order in which to draw them: a marker just before or just after the limb that wears it."""
    return sorted(parts, key=lambda part: -_distance(depths, part))


def _distance(depths: Array, part: Part) -> float:
    if part.worn_on is None:
        return float(depths[part.balls].mean())
    limb, ball = part.worn_on
    behind = depths[part.balls[0]] > depths[ball] + JUST_M
    return _distance(depths, limb) + (JUST_M if behind else -JUST_M)


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

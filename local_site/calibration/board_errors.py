"""How well a rig gives a board's shape back: its corners in space, less the print, pose by pose."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.accuracy import located
from local_site.calibration.physical_camera import PhysicalCamera

MIN_CORNERS = 4


def board_errors(
    cameras_of_pose: Sequence[Sequence[PhysicalCamera]], corners: Array, pixels_of_pose: Sequence[Sequence[Array]]
) -> Array:
    """Located corners less the print laid upon them (N, 3), m, in the cameras' frame.

    Corners (C, 3) on the print in m; for each pose its cameras, and each camera's pixels (C, 2), NaN where unseen.
    """
    parts = [np.zeros((0, 3))]
    for cameras, pixels in zip(cameras_of_pose, pixels_of_pose, strict=True):
        places = located(cameras, pixels)
        known = np.isfinite(places[:, 0])
        if np.sum(known) >= MIN_CORNERS:
            parts.append(places[known] - laid_upon(corners[known], places[known]))
    return np.concatenate(parts)


def laid_upon(shape: Array, places: Array) -> Array:
    """A rigid shape (N, 3) moved as near as it gets to places (N, 3) (Kabsch)."""
    shape_middle, places_middle = shape.mean(axis=0), places.mean(axis=0)
    u, _, vt = np.linalg.svd((shape - shape_middle).T @ (places - places_middle))
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    result: Array = (shape - shape_middle) @ u @ proper @ vt + places_middle
    return result

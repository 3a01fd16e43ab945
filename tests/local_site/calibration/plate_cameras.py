"""Cameras before a grid of control points, for the calibration's tests."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.control_points import ControlPoints
from local_site.calibration.physical_camera import Lens, PhysicalCamera

TICKS = (0.0, 0.25, 0.5, 0.75, 1.0)
GRID = np.array([[x, y, z] for z in (0.0, 0.5, 1.0) for y in TICKS for x in TICKS])


def camera(
    angle_deg: float,
    focal: float = 800.0,
    distance: float = 2.0,
    k1: float = 0.0,
    k2: float = 0.0,
    aspect: float = 1.0,
    drop: float = 0.2,
) -> PhysicalCamera:
    """A camera aimed at the middle of the grid, turned about z to the right, from above."""
    angle = np.radians(angle_deg)
    forward = np.array([np.sin(angle), np.cos(angle), -drop])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.array([right, np.cross(forward, right), forward])
    centre = np.array([0.5, 0.5, 0.5]) - distance * forward
    return PhysicalCamera(Lens(focal, focal * aspect, 320.0, 240.0, k1, k2), rotation, -rotation @ centre)


# The camera that faces right is on the left.
ANGLES = (25.0, -25.0)


def control(
    cameras: Sequence[PhysicalCamera] | None = None, points: Array = GRID, noise: float = 0.0, seed: int = 0
) -> ControlPoints:
    """Control points as these cameras see them."""
    random = np.random.default_rng(seed)
    cameras = [camera(angle) for angle in ANGLES] if cameras is None else cameras
    pixels = tuple(c.pixels(points) + noise * random.standard_normal((len(points), 2)) for c in cameras)
    return ControlPoints(points, pixels, tuple(f"line {k}" for k in range(2, len(points) + 2)), "points.csv")

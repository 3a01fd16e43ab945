"""Two cameras that look down at a printed board, and its poses before them."""

import numpy as np
from scipy.spatial.transform import Rotation

from common.geometry import Array
from local_site.calibration.boards import Board
from local_site.calibration.physical_camera import Lens, PhysicalCamera


def looking_down(side: float, k1: float = 0.0, k2: float = 0.0, focal: float = 800.0) -> PhysicalCamera:
    """A camera 0.9 m from the origin, on the left (-1) or right (1), that looks down at it."""
    turn = np.radians(20.0 * side)
    forward = np.array([-np.sin(turn), np.cos(turn), -0.8])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    rotation = np.array([right, np.cross(forward, right), forward])
    return PhysicalCamera(Lens(focal, focal, 322.0, 236.0, k1, k2), rotation, rotation @ (0.9 * forward))


def poses(board: Board, count: int, seed: int = 3) -> list[tuple[Array, Array]]:
    """Poses of the board (operator_R_board, translation): first flat at the origin, then tilted here and there."""
    random = np.random.default_rng(seed)
    flat = np.diag([1.0, -1.0, -1.0])
    found = [(flat, -flat @ board.middle)]
    while len(found) < count:
        tilt = Rotation.from_euler("xyz", random.uniform((10, -30, -25), (60, 30, 25)), degrees=True).as_matrix()
        middle = random.uniform((-0.12, -0.12, -0.05), (0.12, 0.12, 0.15))
        found.append((tilt @ flat, middle - tilt @ flat @ board.middle))
    return found

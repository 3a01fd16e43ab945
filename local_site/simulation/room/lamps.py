"""The light of the office: tubes on the ceiling, a window at the side."""

import numpy as np

from local_site.simulation.cameras import PinholeCamera
from local_site.simulation.room.shading import Lamps

# To the lamps, in the operator frame: above and before the operator; the window at the operator's left.
DIRECTIONS = np.array([[-0.25, -0.60, 0.76], [0.85, -0.35, 0.40]])
COLOURS = np.array([[0.50, 0.54, 0.56], [0.20, 0.17, 0.15]])  # blue, green, red
AMBIENT = np.array([0.33, 0.33, 0.34])
UP = np.array([0.0, 0.0, 1.0])


def office_lamps(camera: PinholeCamera) -> Lamps:
    """The office's light in this camera's frame."""
    directions = DIRECTIONS / np.linalg.norm(DIRECTIONS, axis=1, keepdims=True)
    rotation = camera.camera_R_operator
    return Lamps(directions @ rotation.T, COLOURS, AMBIENT, rotation @ UP)

"""A pose as configurations write it: millimetres, and degrees about fixed axes."""

import numpy as np
from scipy.spatial.transform import Rotation

from common.geometry import Array, transform

Row3 = tuple[float, float, float]


def transform_of(xyz_mm: Row3, rpy_deg: Row3) -> Array:
    """The rigid transform (4 x 4) of a position in mm and turns about the fixed x, then y, then z, deg."""
    return transform(Rotation.from_euler("xyz", rpy_deg, degrees=True).as_matrix(), 1e-3 * np.array(xyz_mm))

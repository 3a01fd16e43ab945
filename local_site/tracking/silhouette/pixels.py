"""Grey values between the pixels of a picture."""

import numpy as np
from numpy.typing import NDArray

from local_site.kernels.compiled import compiled


@compiled
def grey_at(grey: NDArray[np.uint8], x: float, y: float) -> float:
    """The grey value at a place in px, between pixels by their distances; beyond the border the border's."""
    height, width = grey.shape
    x, y = min(max(x, 0.0), width - 1.001), min(max(y, 0.0), height - 1.001)
    i, j = int(x), int(y)
    u, v = x - i, y - j
    above = (1 - u) * grey[j, i] + u * grey[j, i + 1]
    below = (1 - u) * grey[j + 1, i] + u * grey[j + 1, i + 1]
    return float((1 - v) * above + v * below)

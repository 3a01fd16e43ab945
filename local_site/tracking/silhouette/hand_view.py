"""The hand's part of a silhouette, prepared for fitting: its outline with subpixel precision, its distance field."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import focal_length
from local_site.kernels.compiled import compiled
from local_site.kernels.pictures import grey_at
from local_site.tracking.features.features import Features
from local_site.tracking.silhouette.hand_model.fit import NO_PIXELS, HandView

MIN_PIXELS = 24
MARGIN_PX = 16
PIXELS_WANTED = 64
TANGENT_REACH = 3
PROBE_REACH, PROBE_STEP, PROBES = 3.0, 0.75, 8
MAX_SHIFT_PX = 2.0
PIXEL_SIGMA = 1.6
MODEL_SIGMA_M = 0.005


def make_hand_view(projection: Array, view: Features, wrist: Array) -> HandView | None:
    """The hand of one view with the wrist (3,) in m; None if too little of it is visible."""
    contour, silhouette = view.hand, view.silhouette
    if contour is None or len(contour) < MIN_PIXELS:
        return None
    height, width = silhouette.grey.shape
    x0, y0 = (max(int(v), 0) for v in contour.min(axis=0) - MARGIN_PX)
    x1, y1 = (min(int(v), limit) for v, limit in zip(contour.max(axis=0) + MARGIN_PX, (width, height), strict=True))
    inside = cv2.threshold(silhouette.grey[y0:y1, x0:x1], silhouette.level, 1, cv2.THRESH_BINARY)[1]
    field = cv2.distanceTransform(inside, cv2.DIST_L2, 3) - cv2.distanceTransform(1 - inside, cv2.DIST_L2, 3)
    depth = float(projection[2, :3] @ wrist + projection[2, 3])
    focal_px = focal_length(projection)
    sigma = math.hypot(PIXEL_SIGMA, MODEL_SIGMA_M * focal_px / max(depth, 1e-6))
    outline = _refined(silhouette.grey, contour) + view.hand_shift
    step = max(1, round(len(outline) / PIXELS_WANTED))
    pixels, origin = np.ascontiguousarray(outline[::step]), np.array([x0, y0], dtype=np.float64) + view.hand_shift
    grey = silhouette.grey if silhouette.picture is None else silhouette.picture
    shift = view.hand_shift
    return HandView(projection, focal_px, pixels, field, origin, sigma, outline, grey, shift, NO_PIXELS, 1.0)


@compiled
def _refined(grey: NDArray[np.uint8], contour: Array) -> Array:
    """The pixels of a contour (M, 2), without those at its ends, moved along its normal to the steepest fall of grey.

    That is the edge also where the skin lies in shadow, and it does not depend on the threshold.
    """
    refined = np.empty((len(contour) - 2 * TANGENT_REACH, 2))
    values = np.empty(PROBES + 1)
    for n in range(len(refined)):
        k = n + TANGENT_REACH
        x, y = contour[k]
        before, after = contour[k - TANGENT_REACH], contour[k + TANGENT_REACH]
        # OpenCV orders outer contours so that the shape is on the left in an image with y down.
        nx, ny = before[1] - after[1], after[0] - before[0]
        length = max(math.sqrt(nx * nx + ny * ny), 1e-9)
        nx, ny = nx / length, ny / length
        for j in range(PROBES + 1):
            along = j * PROBE_STEP - PROBE_REACH
            values[j] = grey_at(grey, x + along * nx, y + along * ny)
        shift = _steepest(values)
        refined[n] = x + shift * nx, y + shift * ny
    return refined


@compiled
def _steepest(values: Array) -> float:
    """The mean position in px from the middle of values probed across an edge, weighted by their squared fall."""
    total, position = 0.0, 0.0
    for j in range(len(values) - 1):
        fall = max(values[j] - values[j + 1], 0.0) ** 2
        total += fall
        position += fall * ((j + 0.5) * PROBE_STEP - PROBE_REACH)
    return min(max(position / total, -MAX_SHIFT_PX), MAX_SHIFT_PX) if total > 1.0 else 0.0

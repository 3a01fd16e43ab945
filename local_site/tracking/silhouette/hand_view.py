"""The hand's part of a silhouette, made ready for fitting: its outline to a fraction of a pixel, its distance field."""

import math

import cv2
import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.contour import Silhouette
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.hand_model.descent import focal_length
from local_site.tracking.silhouette.hand_model.fit import HandView

MIN_PIXELS = 24
MARGIN_PX = 16
PIXELS_WANTED = 64
TANGENT_REACH = 3
PROBE = np.arange(-3.0, 3.01, 0.75)
MAX_SHIFT_PX = 2.0
PIXEL_SIGMA = 1.6
MODEL_SIGMA_M = 0.005


def make_hand_view(projection: Array, view: Features, wrist: Array) -> HandView | None:
    """The hand of one view with the wrist (3,) in m; None where too little of it shows."""
    contour, silhouette = view.hand, view.silhouette
    if contour is None or len(contour) < MIN_PIXELS:
        return None
    field, origin = _distance_field(silhouette, contour)
    depth = float(projection[2, :3] @ wrist + projection[2, 3])
    focal_px = focal_length(projection)
    sigma = math.hypot(PIXEL_SIGMA, MODEL_SIGMA_M * focal_px / max(depth, 1e-6))
    outline = _refined(silhouette, contour) + view.hand_shift
    step = max(1, round(len(outline) / PIXELS_WANTED))
    return HandView(
        projection=projection,
        focal_px=focal_px,
        pixels=np.ascontiguousarray(outline[::step]),
        field=field,
        origin=origin + view.hand_shift,
        sigma=sigma,
        outline=outline,
        grey=silhouette.grey,
        shift=view.hand_shift,
    )


def _distance_field(silhouette: Silhouette, contour: Array) -> tuple[np.ndarray, Array]:
    height, width = silhouette.grey.shape
    x0, y0 = (max(int(v), 0) for v in contour.min(axis=0) - MARGIN_PX)
    x1, y1 = (min(int(v), limit) for v, limit in zip(contour.max(axis=0) + MARGIN_PX, (width, height), strict=True))
    inside = cv2.threshold(silhouette.grey[y0:y1, x0:x1], silhouette.level, 1, cv2.THRESH_BINARY)[1]
    field = cv2.distanceTransform(inside, cv2.DIST_L2, 3) - cv2.distanceTransform(1 - inside, cv2.DIST_L2, 3)
    return field, np.array([x0, y0], dtype=np.float64)


def _refined(silhouette: Silhouette, contour: Array) -> Array:
    """The pixels of a contour (M, 2), moved along its normal to where the grey falls most.

    That place is the edge itself also where the skin lies in shadow, and does not depend on the threshold.
    """
    k = np.arange(TANGENT_REACH, len(contour) - TANGENT_REACH)
    tangent = contour[k + TANGENT_REACH] - contour[k - TANGENT_REACH]
    # OpenCV walks outer contours so that the shape lies to the left in an image with y down
    normal = np.column_stack([-tangent[:, 1], tangent[:, 0]])
    normal /= np.maximum(np.hypot(normal[:, 0], normal[:, 1]), 1e-9)[:, None]
    x, y = (contour[k, d, None] + PROBE * normal[:, d, None] for d in (0, 1))
    grey = cv2.remap(
        silhouette.grey, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    ).astype(np.float64)
    fall = np.maximum(grey[:, :-1] - grey[:, 1:], 0.0) ** 2
    total = fall.sum(axis=1)
    shift = np.where(total > 1.0, fall @ (0.5 * (PROBE[:-1] + PROBE[1:])) / np.maximum(total, 1e-9), 0.0)
    return contour[k] + np.clip(shift, -MAX_SHIFT_PX, MAX_SHIFT_PX)[:, None] * normal

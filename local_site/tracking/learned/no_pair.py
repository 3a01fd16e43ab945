"""Why no two views see the operator's hand, camera by camera: a dark picture, or one without a hand."""

from collections.abc import Collection

import numpy as np

from common.cameras.camera import Image
from local_site.calibration.rig import Rig
from local_site.tracking.silhouette.hand_model.fit import MIN_VIEWS
from local_site.tracking.tracker import TrackingReason, Views

DARK_LEVEL, NEARLY_ALL, STRIDE = 20.0, 99.5, 4  # of 255; per cent of every fourth pixel of every fourth row


def is_dark(image: Image) -> bool:
    """Whether a picture (H, W) or (H, W, C) is black but for a few pixels."""
    return bool(np.percentile(image[::STRIDE, ::STRIDE], NEARLY_ALL) < DARK_LEVEL)


def why_no_pair(reason: str, rig: Rig, views: Views, blind: Collection[int]) -> str:
    """A more exact sentence than `reason` where there is one; `blind` are the views without any hand, by number."""
    names = [camera.name for camera in rig.cameras]
    dark = [name for name, view in zip(names, views.views, strict=True) if is_dark(view.current.image)]
    if dark:
        return "; ".join(f"{name}: {TrackingReason.DARK}" for name in dark)
    if len(names) - len(blind) < MIN_VIEWS and reason == TrackingReason.HANDS_DIFFER:
        return "; ".join(f"{names[k]}: {TrackingReason.NO_HAND}" for k in sorted(blind))
    return reason

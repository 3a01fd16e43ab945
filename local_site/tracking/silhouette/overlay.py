"""What was seen of the arm in one view, for drawing over the picture as the camera gave it."""

from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.calibration.triangulation import project
from local_site.tracking.silhouette.features import Features
from local_site.tracking.tracker import Overlay


def overlay_of(camera: CameraCalibration, view: Features, points: Sequence[Array]) -> Overlay:
    """The overlay of a view; points (3,) in m are elbow and wrist, and index and thumb where they are known."""
    upper = view.upper_arm
    pixels = [*_as_taken(camera, project(camera.matrix, np.array(points))), None, None]
    return Overlay(
        contour=np.rint(_as_taken(camera, view.silhouette.contour)).astype(np.int32),
        forearm_line=_as_taken(camera, np.array([view.forearm.at(0.0), view.guess.wrist])),
        upper_arm_line=None if upper is None else _as_taken(camera, np.array([upper.at(0.0), view.guess.shoulder_end])),
        elbow=pixels[0],
        wrist=pixels[1],
        index=pixels[2],
        thumb=pixels[3],
    )


def _as_taken(camera: CameraCalibration, pixels: Array) -> Array:
    """Pixels (..., 2) of the straightened picture, in the picture that the lens gave."""
    return pixels if camera.lens is None else camera.lens.distort_pixels(pixels)

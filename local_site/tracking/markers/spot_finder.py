"""One camera's part in marker tracking: its spots at the instant of the views, each frame searched once."""

from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from common.cameras.camera import Frame
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.tracking.markers.spots import Spots, find_spots
from local_site.tracking.tracker import View

MAX_STEP_PX = 80.0
# A spot that speeds up or turns between two exposures leaves the straight line by this share of its way at most.
BENDING = 0.02


class SpotFinder:
    """Finds the spots of one camera, straightens them by its lens, and interpolates them between two exposures."""

    def __init__(self, camera: CameraCalibration, min_contrast: float) -> None:
        self._camera = camera
        self._min_contrast = min_contrast
        self._found: dict[tuple[int, int], Spots | str] = {}

    def spots(self, view: View) -> Spots | str:
        """The spots at the view's instant, or a sentence, with the camera's name, that says why there are none."""
        now = self._of_frame(view.current)
        if view.previous is None or view.weight >= 1.0 or isinstance(now, str):
            return now
        before = self._of_frame(view.previous)
        return before if isinstance(before, str) else interpolated(before, now, view.weight)

    def _of_frame(self, frame: Frame) -> Spots | str:
        key = (frame.seq, frame.capture_ns)
        known = self._found.get(key)
        if known is None:
            known = self._search(frame)
            self._found = {**dict(list(self._found.items())[-1:]), key: known}
        return known

    def _search(self, frame: Frame) -> Spots | str:
        found = find_spots(frame.image, self._min_contrast)
        if isinstance(found, str):
            return f"{self._camera.name}: {found}"
        lens = self._camera.lens
        return found if lens is None else replace(found, pixels=lens.undistort_pixels(found.in_picture))


def interpolated(before: Spots, now: Spots, weight: float) -> Spots:
    """The spots that both frames show, at (1 - weight) * before + weight * now.

    They are paired so that the sum of squared steps is least, which a step common to all of them does not change.
    """
    steps2 = np.sum((before.pixels[:, None] - now.pixels[None]) ** 2, axis=2)
    rows, columns = linear_sum_assignment(steps2)
    near = steps2[rows, columns] <= MAX_STEP_PX**2
    a, b = rows[near], columns[near]
    bent = 4.0 * weight * (1.0 - weight) * BENDING * np.sqrt(steps2[a, b])
    noise2 = ((1.0 - weight) * before.sigmas[a]) ** 2 + (weight * now.sigmas[b]) ** 2

    def between(start: Array, end: Array) -> Array:
        return (1.0 - weight) * start + weight * end

    return Spots(
        in_picture=between(before.in_picture[a], now.in_picture[b]),
        pixels=between(before.pixels[a], now.pixels[b]),
        sigmas=np.sqrt(noise2 + bent**2),
        areas=between(before.areas[a], now.areas[b]),
    )

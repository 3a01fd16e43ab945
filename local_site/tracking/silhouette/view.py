"""One camera's part in tracking: frames in, features out; each frame is measured once."""

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Frame
from local_site.calibration.lens import Maps
from local_site.calibration.rig import CameraCalibration
from local_site.tracking.silhouette.blending import blend
from local_site.tracking.silhouette.contour import find_silhouette, to_grey
from local_site.tracking.silhouette.features import Features, measure
from local_site.tracking.silhouette.posture import Posture
from local_site.tracking.silhouette.threshold import find_threshold
from local_site.tracking.tracker import View

MIN_SIDE_PX = 32
FOLLOWED_EVERY = 15
FOLLOWED_SHARE = 0.3


class ViewMeter:
    """Measures the frames of one camera with a threshold that follows slow changes of the light."""

    def __init__(self, camera: CameraCalibration) -> None:
        self._name = camera.name
        self._lens = camera.lens
        self._size_px = camera.size_px
        self._maps: tuple[tuple[int, ...], Maps] | None = None
        self._level: float | None = None
        self._since = 0
        self._measured: dict[tuple[int, int], Features | str] = {}

    def features(self, view: View, guess: Posture | None) -> Features | str:
        """The features at the view's instant, or a sentence that says why there are none."""
        now = self._measure(view.current, guess)
        if view.previous is None or view.weight >= 1.0 or isinstance(now, str):
            return now
        before = self._measure(view.previous, guess)
        return before if isinstance(before, str) else blend(before, now, view.weight)

    def forget(self) -> None:
        """Find the threshold anew with the next frame."""
        self._level = None

    def _measure(self, frame: Frame, guess: Posture | None) -> Features | str:
        key = (frame.seq, frame.capture_ns)
        known = self._measured.get(key)
        if known is None:
            known = self._measure_image(frame, guess)
            self._measured = {**dict(list(self._measured.items())[-1:]), key: known}
        return known

    def _measure_image(self, frame: Frame, guess: Posture | None) -> Features | str:
        image = frame.image
        if (
            image.dtype != np.uint8
            or image.ndim not in (2, 3)
            or min(image.shape) == 0
            or min(image.shape[:2]) < MIN_SIDE_PX
        ):
            return f"{self._name}: the picture is too small or of a wrong kind"
        height, width = image.shape[:2]
        if self._size_px not in (None, (width, height)):
            expected = "{}x{}".format(*self._size_px or ())
            return f"{self._name}: the picture is {width}x{height}, but was calibrated at {expected}"
        grey = self._straightened(to_grey(image))
        level = self._followed_level(grey)
        if isinstance(level, str):
            return f"{self._name}: {level}"
        silhouette = find_silhouette(grey, level)
        if silhouette is None:
            return f"{self._name}: no arm in the picture"
        features = measure(silhouette, guess)
        if features is None:
            return f"{self._name}: no forearm can be made out; hold the arm bent and across the view"
        return f"{self._name}: the hand is cropped by the border" if features.hand_cropped else features

    def _followed_level(self, grey: NDArray[np.uint8]) -> float | str:
        """The threshold, found anew now and then and followed slowly, or why there is none yet.

        A later picture without two clear modes changes nothing: the arm may just have left it.
        """
        self._since += 1
        if self._level is not None and self._since < FOLLOWED_EVERY:
            return self._level
        self._since = 0
        threshold = find_threshold(grey)
        if self._level is None:
            if threshold.level is None:
                return threshold.reason
            self._level = threshold.level
        elif threshold.level is not None:
            self._level += FOLLOWED_SHARE * (threshold.level - self._level)
        return self._level

    def _straightened(self, grey: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The picture of a pinhole camera, for which the rig's projection holds."""
        if self._lens is None or not (self._lens.k1 or self._lens.k2):
            return grey
        if self._maps is None or self._maps[0] != grey.shape:
            self._maps = grey.shape, self._lens.undistortion_maps(grey.shape[1], grey.shape[0])
        straight = cv2.remap(grey, *self._maps[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(straight, dtype=np.uint8)

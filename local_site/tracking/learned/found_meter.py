"""One camera's part in a room: the silhouettes that were found in its frames, measured, and drawn."""

from collections.abc import Sequence
from functools import partial

from common.cameras.camera import Frame
from common.geometry import Array
from local_site.calibration.rig import CameraCalibration
from local_site.tracking.features.features import Features
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import Silhouette
from local_site.tracking.features.view_meter import blend, features_of, overlay_of
from local_site.tracking.tracker import FrameCache, Overlay, View

NOT_FOUND = "the arm was not looked for in the earlier picture"


class FoundMeter:
    """Measures the frames of one camera by silhouettes that others find."""

    def __init__(self, camera: CameraCalibration) -> None:
        self._camera = camera
        self._frames = FrameCache(blend)
        self._shown: tuple[Frame, Silhouette | str] | None = None

    def show(self, frame: Frame, silhouette: Silhouette | str) -> None:
        """Take what was found in a frame: its silhouette, or a sentence why there is none."""
        self._shown = frame, silhouette

    def features(self, view: View, guess: Posture | None) -> Features | str:
        """The features at the view's instant, or a sentence with the reason why there are none."""
        found = self._frames.at(view, partial(self._measure, guess=guess))
        return f"{self._camera.name}: {found}" if isinstance(found, str) else found

    def overlay(self, view: Features, points: Sequence[Array]) -> Overlay:
        """The overlay of a view; points (3,) in m are elbow and wrist, and index and thumb where they are known."""
        return overlay_of(self._camera, view, points)

    def forget(self) -> None:
        """Nothing is kept that could mislead."""

    def _measure(self, frame: Frame, guess: Posture | None) -> Features | str:
        if self._shown is None or self._shown[0] is not frame:
            return NOT_FOUND
        silhouette = self._shown[1]
        return silhouette if isinstance(silhouette, str) else features_of(silhouette, guess)

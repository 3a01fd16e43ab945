"""A tracker of one's own: the brightest spot in both pictures is the wrist. Try it: python examples/tracker.py"""

import cv2
import numpy as np
from numpy.typing import NDArray

from farhand.tracker import (
    ArmEstimate,
    Frame,
    TrackerHost,
    TrackerKind,
    TrackingStatus,
    View,
    Views,
    triangulate,
)

LEAST_GREY = 200


class SpotTracker:
    """Measures each instant by itself; the point is the spot's centre."""

    def __init__(self, host: TrackerHost) -> None:
        self._rig = host.rig

    def track(self, views: Views) -> ArmEstimate:
        """The spot at this instant, or why it was not found."""
        found = [brightest(view.current.image) for view in views.views]
        if len(found) != len(self._rig.cameras) or any(pixel is None for pixel in found):
            return ArmEstimate(views.t_ns, TrackingStatus.LOST, "no bright spot in every picture")
        cameras = zip(self._rig.cameras, found, strict=True)
        wrist = triangulate(self._rig.matrices, [camera.undistort_pixels(pixel) for camera, pixel in cameras])
        sure = {"wrist": 0.002**2 * np.eye(3)}
        return ArmEstimate(views.t_ns, TrackingStatus.TRACKED, "", wrist=wrist, covariances=sure)


def brightest(image: NDArray[np.uint8]) -> NDArray[np.float64] | None:
    """The brightest spot's pixel (2,), None where nothing is bright."""
    grey = cv2.GaussianBlur(image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), (0, 0), 3.0)
    _, most, _, pixel = cv2.minMaxLoc(grey)
    return np.array(pixel, float) if most > LEAST_GREY else None


spot = TrackerKind(SpotTracker, "the brightest spot", "markers")  # what an entry point of `farhand.trackers` names

if __name__ == "__main__":
    from local_site.simulation.cameras import exact_rig
    from local_site.simulation.config import StereoConfig

    rig, place = exact_rig(StereoConfig()), np.array([0.5, 0.45, 0.7, 1.0])
    images = np.zeros((2, 480, 640), np.uint8)
    for image, matrix in zip(images, rig.matrices, strict=True):
        u, v, w = matrix @ place
        cv2.circle(image, (round(u / w), round(v / w)), 8, 255, cv2.FILLED)
    estimate = spot.make(TrackerHost(rig)).track(Views(0, tuple(View(Frame(image, 0, 0)) for image in images)))
    print(estimate.status.value, "off by", np.round(1000 * np.linalg.norm(estimate.wrist - place[:3]), 1), "mm")

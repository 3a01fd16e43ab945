"""Loads the installed models and makes of them what watches each camera for hands."""

from functools import cache

from local_site.calibration.rig import Rig
from local_site.tracking.landmarks.hand_landmarks import HandLandmarker
from local_site.tracking.landmarks.model_files import (
    HAND_LANDMARKS,
    PALM_DETECTION,
    QUICK_HAND_LANDMARKS,
    read_model,
)
from local_site.tracking.landmarks.network import LandmarkNetwork
from local_site.tracking.landmarks.palm_detector import PalmDetector
from local_site.tracking.landmarks.view_follower import ViewFollower
from local_site.tracking.landmarks.view_hands import ViewHands


def view_hands(rig: Rig, right_arm: bool) -> list[ViewHands]:
    """Make what watches each of the rig's cameras for hands; ModelError when models or runtime are missing."""
    return [ViewHands(camera, ViewFollower(*_networks()), right_arm) for camera in rig.cameras]


@cache
def _networks() -> tuple[PalmDetector, HandLandmarker, HandLandmarker]:
    careful, quick = (HandLandmarker(LandmarkNetwork(read_model(m), 3)) for m in (HAND_LANDMARKS, QUICK_HAND_LANDMARKS))
    return PalmDetector(LandmarkNetwork(read_model(PALM_DETECTION), 2)), careful, quick

"""Hands of the hand model as a landmark network sees them: their 21 landmarks in the pictures of a rig's cameras."""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from common.geometry import Array
from local_site.calibration.rig import CameraCalibration, Rig
from local_site.calibration.triangulation import focal_length, project
from local_site.tracking.landmarks.crop import Crop
from local_site.tracking.landmarks.hand_landmarks import HandLandmarks
from local_site.tracking.silhouette.hand_model.fit import NO_VIEW, HandView
from local_site.tracking.silhouette.hand_model.landmark_equations import landmark_points
from local_site.tracking.silhouette.hand_model.skeleton import HandPose, Person, hand_spheres
from tests.local_site.tracking.rendered_arm import rig_of
from tests.local_site.tracking.silhouette.hand_model.posed_hands import PERSON, PROJECTIONS

CROP_PER_HAND = 1.3
PAIR_RIG: Rig = rig_of(PROJECTIONS)
STILL = np.zeros(3)


def landmarks_of(pose: HandPose, person: Person = PERSON) -> Array:
    """The landmarks (21, 3) of a hand in m."""
    return landmark_points(hand_spheres(pose, person).centres)


def seen_by(camera: CameraCalibration, landmarks: Array, right: float = 0.95, score: float = 0.9) -> HandLandmarks:
    """What a camera shows of landmarks (21, 3) in m."""
    pixels = camera.distort_pixels(project(camera.matrix, landmarks))
    side_px = CROP_PER_HAND * float(np.ptp(pixels, axis=0).max())
    return HandLandmarks(pixels, score, right, Crop(pixels.mean(axis=0), side_px, 0.0))


def seen_by_all(rig: Rig, landmarks: Array, right: float = 0.95, score: float = 0.9) -> list[HandLandmarks]:
    """What every camera shows of landmarks (21, 3) in m."""
    return [seen_by(camera, landmarks, right, score) for camera in rig.cameras]


def landmark_views(
    landmarks: Array, sigma_px: float, noise_px: float = 0.0, random: Generator | None = None
) -> list[HandView]:
    """The pair's views of landmarks (21, 3) in m, with noise, as the fit takes them."""
    return [landmark_view(matrix, landmarks, sigma_px, noise_px, random) for matrix in PROJECTIONS]


def landmark_view(
    projection: Array, landmarks: Array, sigma_px: float, noise_px: float = 0.0, random: Generator | None = None
) -> HandView:
    """One view of landmarks (21, 3) in m, with noise, as the fit takes it."""
    pixels = project(projection, landmarks)
    if random is not None:
        pixels = pixels + random.normal(0.0, noise_px, pixels.shape)
    return NO_VIEW._replace(
        projection=projection, focal_px=focal_length(projection), landmarks=pixels, landmark_sigma=sigma_px
    )


def moved(landmarks: Array, by: Sequence[float] | Array) -> Array:
    """The landmarks (21, 3) elsewhere, in m."""
    elsewhere: Array = landmarks + np.asarray(by, dtype=float)
    return elsewhere

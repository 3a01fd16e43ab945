"""Hands in known poses as two cameras see them: capsules drawn with OpenCV and measured like pictures."""

from collections.abc import Sequence

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from local_site.simulation.cameras import stereo_pair
from local_site.simulation.config import StereoConfig
from local_site.tracking.features.features import Features
from local_site.tracking.features.medial import MedialLine
from local_site.tracking.features.posture import Posture
from local_site.tracking.features.silhouette import find_silhouette, to_grey
from local_site.tracking.silhouette.hand_model.fit import HandView
from local_site.tracking.silhouette.hand_model.habits import GRIPPER, Belief, prior_information
from local_site.tracking.silhouette.hand_model.skeleton import (
    CAPSULES,
    FOREARM,
    MIDDLE_TIP,
    HandPose,
    Person,
    hand_spheres,
    turned,
)
from local_site.tracking.silhouette.hand_view import make_hand_view

STEREO = StereoConfig()
PROJECTIONS = tuple(camera.projection for camera in stereo_pair(STEREO))
SIZE = (STEREO.width_px, STEREO.height_px)
FINE, SHIFT = 4, 4
# OpenCV also fills the pixels that an outline touches: about half a fine pixel too much all round.
EXCESS_PX = 0.47 / FINE
DARK, BRIGHT, LEVEL = 9.0, 170.0, 50.0
LINE = MedialLine(np.zeros(2), np.array([1.0, 0.0]))
UNSEEN = np.full((2, 2), np.nan)
WRIST = np.array([0.50, 0.45, 0.60])
# Columns: to the middle knuckle, to the thumb's side, out of the back of the hand.
POINTING = np.column_stack([[-0.8, 0.0, 0.6], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8]])
TO_ELBOW = np.array([0.70, -0.10, -0.70]) / np.linalg.norm([0.70, -0.10, -0.70])
PERSON = Person(1.0, True, TO_ELBOW)
WRIST_COVARIANCE = np.diag([0.008, 0.008, 0.008]) ** 2
CIRCLE = 2 * np.pi * np.arange(48) / 48
MIRROR = np.diag([-1.0, 1.0, 1.0])


def pose_of(
    turn: Sequence[float] | Array = (0.0, 0.0, 0.0), posture: Array = GRIPPER, wrist: Array = WRIST
) -> HandPose:
    """A hand turned by a vector (3,) from the usual pointing."""
    return HandPose(np.array(wrist), turned(np.array(turn, dtype=float)) @ POINTING, np.array(posture))


def circles_of(pose: HandPose, person: Person, projection: Array) -> tuple[Array, Array]:
    """Centres (S, 2) and radii (S,) in px of the hand's spheres in a view."""
    spheres = hand_spheres(pose, person)
    seen = spheres.centres @ projection[:, :3].T + projection[:, 3]
    return seen[:, :2] / seen[:, 2:], spheres.radii * STEREO.focal_px / seen[:, 2]


def mask_of(centres: Array, radii: Array, scale: int) -> Image:
    """The union of the capsules, (scale * H, scale * W), 255 inside; pixel (0, 0) is centred at (0, 0)."""
    mask = np.zeros((scale * SIZE[1], scale * SIZE[0]), np.uint8)
    circle = np.column_stack([np.cos(CIRCLE), np.sin(CIRCLE)])
    rims = centres[:, None] + (radii - EXCESS_PX)[:, None, None] * circle
    fixed = np.rint((scale * rims + (scale - 1) / 2) * (1 << SHIFT)).astype(np.int32)
    for a, b in CAPSULES:
        hull = cv2.convexHull(np.concatenate([fixed[a], fixed[b]]))
        cv2.fillConvexPoly(mask, hull, 255, cv2.LINE_8, SHIFT)
    return mask


def picture_of(pose: HandPose, person: Person, projection: Array) -> tuple[Image, Array, Array]:
    """A grey picture (H, W) of a hand and the end of its forearm, and the pixels of wrist and forearm (2,)."""
    centres, radii = circles_of(pose, person, projection)
    grey = cv2.resize(mask_of(centres, radii, FINE), SIZE, interpolation=cv2.INTER_AREA)
    picture = np.rint(DARK + (BRIGHT - DARK) / 255 * cv2.GaussianBlur(grey, (0, 0), 0.7)).astype(np.uint8)
    return picture, centres[FOREARM - 2 : FOREARM].mean(axis=0), centres[FOREARM:].mean(axis=0)


def hand_view(pose: HandPose, person: Person, projection: Array) -> HandView:
    """One view of a hand whose outline begins a little before the wrist."""
    picture, wrist, forearm = picture_of(pose, person, projection)
    silhouette = find_silhouette(to_grey(picture), LEVEL)
    assert silhouette is not None
    contour = silhouette.contour
    kept = (contour - wrist) @ (forearm - wrist) < 0.4 * float(np.sum((forearm - wrist) ** 2))
    first = int(np.flatnonzero(kept & ~np.roll(kept, 1))[0])
    features = Features(
        forearm=LINE,
        root=LINE,
        forearm_sides=UNSEEN,
        upper_arm=None,
        upper_arm_sides=UNSEEN,
        wrist=None,
        hand=np.roll(contour, -first, axis=0)[: np.count_nonzero(kept)],
        half_width=20.0,
        silhouette=silhouette,
        guess=Posture(forearm, forearm, wrist, wrist, 20.0),
    )
    view = make_hand_view(projection, features, pose.wrist)
    assert view is not None
    return view


def hand_views(pose: HandPose, person: Person = PERSON, projections: Sequence[Array] = PROJECTIONS) -> list[HandView]:
    return [hand_view(pose, person, projection) for projection in projections]


def far_end(pose: HandPose, person: Person = PERSON) -> Array:
    """The middle finger's tip, about the far end of the outline."""
    tip: Array = hand_spheres(pose, person).centres[MIDDLE_TIP]
    return tip


def known(belief: Belief, turn_known: bool) -> Array:
    """The information (16, 16) about a hand whose wrist is known from the limbs."""
    return prior_information(WRIST_COVARIANCE, belief.information, turn_known)


def angle_deg(first: Array, second: Array) -> float:
    """The angle between two rotations (3, 3)."""
    return float(np.degrees(np.arccos(np.clip(0.5 * (np.trace(first @ second.T) - 1), -1, 1))))

"""A first pose of the hand model from the landmarks of a hand in m: the typical posture whose shape fits best."""

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.habits import GRIPPER, Belief
from local_site.tracking.silhouette.hand_model.landmark_equations import landmark_points
from local_site.tracking.silhouette.hand_model.skeleton import PALM, PARAMETERS, HandPose, Person, pose_spheres

FLAT = np.array([0.05, 0.1, 0.0, 0.1, 0.7, 0.2, 0.0, 0.0, 0.0, 0.0])
FIST = np.array([1.3, 1.5, 0.0, 0.0, 0.5, 0.6, 0.5, 0.0, 0.0, 0.0])
POINTING = np.array([0.1, 0.1, 1.2, 0.0, 0.5, 0.6, 0.5, 0.0, 0.0, 0.0])
TYPICAL = (GRIPPER, FLAT, FIST, POINTING)
ANY_SIGMA = np.array([0.6, 0.6, 0.5, 0.12, 0.35, 0.35, 0.35])
PALM_LANDMARKS = (1, 5, 9, 13, 17)
KNUCKLES = (5, 9, 13, 17)
SHAPE_GAIN = 2.5  # makes of the shares that hands differ by, 0.3 to 0.7, all from 0 to 1


def any_posture(sizes: Belief) -> Belief:
    """What is believed of a hand in any posture, whose sizes are those of another belief."""
    posture = np.mean(TYPICAL, axis=0)
    posture[PALM:] = sizes.posture[PALM:]
    information = np.zeros((PARAMETERS, PARAMETERS))
    information[:PALM, :PALM] = np.diag(1 / ANY_SIGMA**2)
    information[PALM:, PALM:] = np.linalg.inv(np.linalg.inv(sizes.information)[PALM:, PALM:])
    return Belief(posture, information)


def scale_of(landmarks: Array, right_arm: bool) -> float:
    """The size of a palm with landmarks (21, 3) in m against the average one's, by its length."""
    average = landmark_points(pose_spheres(GRIPPER, 1.0, right_arm)[0])
    seen, usual = (np.linalg.norm(hand[list(KNUCKLES)] - hand[0], axis=1) for hand in (landmarks, average))
    return float(np.median(seen / usual))


def pose_from_landmarks(landmarks: Array, person: Person, sizes: Array) -> HandPose:
    """The pose of the typical posture that fits best upon landmarks (21, 3) in m, NaN where unknown.

    `sizes` (3,) are logarithms.
    """
    fits, known = [], ~np.isnan(landmarks[:, 0])
    for typical in TYPICAL:
        posture = np.concatenate([typical[:PALM], sizes])
        model = landmark_points(pose_spheres(posture, person.scale, person.right_arm)[0])
        rotation, wrist, off = laid_upon(model[known], landmarks[known])
        fits.append((off, HandPose(wrist, rotation, posture)))
    return min(fits, key=lambda fit: fit[0])[1]


def right_by_shape(landmarks: Array) -> float:
    """How much the shape of landmarks (21, 3) in m is that of a right hand: from 0, a left one, to 1.

    Fingers bend towards the palm: a left hand does not fit upon a right one that is bent; flat hands hardly differ.
    """
    scale, off = scale_of(landmarks, True), []
    for right_arm in (True, False):
        models = (landmark_points(pose_spheres(typical, scale, right_arm)[0]) for typical in TYPICAL)
        off.append(min(laid_upon(model, landmarks)[2] for model in models))
    share = off[1] / max(sum(off), 1e-9)
    return min(max(0.5 + SHAPE_GAIN * (share - 0.5), 0.0), 1.0)


def laid_upon(model: Array, points: Array) -> tuple[Array, Array, float]:
    """The rotation (3, 3) and translation (3,) that lay points (N, 3) best upon others, and the rms distance left."""
    middle, target = model.mean(axis=0), points.mean(axis=0)
    u, _, vt = np.linalg.svd((points - target).T @ (model - middle))
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation: Array = u @ turn @ vt
    left = (points - target) - (model - middle) @ rotation.T
    return rotation, target - rotation @ middle, float(np.sqrt(np.mean(np.sum(left * left, axis=1))))

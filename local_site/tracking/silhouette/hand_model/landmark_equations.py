"""Normal equations of a hand's state from its landmarks in a view: the joints of the hand model; compiled."""

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.silhouette.hand_model.outline_equations import Circles, add_row
from local_site.tracking.silhouette.hand_model.skeleton import MIDDLE_KNUCKLE, THUMB, WRIST

LANDMARKS = 21
# The wrist's landmark lies this fraction of the way from the joint to the middle knuckle: on the wrist's crease.
CREASE = 0.18

_thumb = [(THUMB + j, THUMB + j, THUMB + j) for j in range(4)]
_fingers = [(s, s, s) for s in range(THUMB)]
OF_SPHERES: NDArray[np.intp] = np.array([(WRIST, WRIST + 1, MIDDLE_KNUCKLE), *_thumb, *_fingers], dtype=np.intp)
SHARES = np.array([(0.5 - CREASE / 2, 0.5 - CREASE / 2, CREASE), *[(1.0, 0.0, 0.0)] * (LANDMARKS - 1)])


def landmark_of(sphere: int) -> int:
    """The landmark that is a sphere's centre, by the sphere's number."""
    return int(np.flatnonzero((OF_SPHERES[:, 0] == sphere) & (SHARES[:, 0] == 1.0))[0])


@compiled
def landmark_points(centres: Array) -> Array:
    """Compute where the landmarks (21, 3) of a hand are, by the centres (24, 3) of its spheres."""
    points = np.zeros((LANDMARKS, 3))
    for n in range(LANDMARKS):
        for k in range(3):
            points[n] += SHARES[n, k] * centres[OF_SPHERES[n, k]]
    return points


@compiled
def add_landmarks(
    landmarks: Array, circles: Circles, sigma: float, robust: float, information: Array, gradient: Array
) -> float:
    """Add landmarks (21, 2) in px, NaN where unknown, to the gradient (P,) and to the lower half of the information
    (P, P); returns their robust (Cauchy) cost."""
    cost, rows = 0.0, np.empty((2, len(gradient)))
    for n in range(len(landmarks)):
        if np.isnan(landmarks[n, 0]):
            continue
        off = np.empty(2)
        for d in range(2):
            off[d], rows[d] = landmarks[n, d], 0.0
            for k in range(3):
                s, share = OF_SPHERES[n, k], SHARES[n, k]
                off[d] -= share * circles.centres[s, d]
                for p in range(len(gradient)):
                    rows[d, p] -= share * circles.centre_jacobian[s, d, p] / sigma
        off /= sigma
        square = (off[0] ** 2 + off[1] ** 2) / robust**2
        cost += np.log1p(square) * robust**2
        for d in range(2):
            add_row(information, gradient, rows[d], off[d], 1.0 / (1.0 + square))
    return float(cost)

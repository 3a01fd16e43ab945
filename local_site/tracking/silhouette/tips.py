"""Finger tips on their own: a fitted tip moved to where its outline really lies, as no hand is quite the model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS, Contact, HandView
from local_site.tracking.silhouette.hand_model.placement import Placed
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES, INDEX_TIP, THUMB_TIP
from local_site.tracking.silhouette.tip_edges import settle

FREEDOM_M = 0.008
SHAPE_SIGMA_M = 0.001
MISFIT_SHARE = 0.1
NO_EDGES = (np.eye(3, 4), 1.0, np.empty((0, 2)), np.empty(0, np.intp), np.empty((0, 0), np.uint8), np.zeros(2))


@dataclass(frozen=True, slots=True)
class Finger:
    """A finger by the number of its last sphere, and from what its tip errs.

    `edges` is the share of the variance that its edges tell, `depth_sigma_m` how deep in its round end the tip lies,
    `hidden_sigmas_m` what the model adds where no view and where one shows the end in outline.
    """

    sphere: int
    edges: float
    depth_sigma_m: float
    hidden_sigmas_m: tuple[float, float]


# The index's end is seldom hidden by more than another finger, before which its edges of grey show; the thumb
# vanishes behind the hand, where nothing but habit says where it is.
INDEX = Finger(INDEX_TIP, 1.0, 0.0, (0.0025, 0.0025))
THUMB = Finger(THUMB_TIP, 0.35, 0.0045, (0.019, 0.0095))


@dataclass(frozen=True, slots=True)
class Tip:
    """A finger tip on the skin (3,), its covariance (3, 3) in m², and how many views show it in outline."""

    point: Array
    covariance: Array
    views: int


def find_tip(views: Sequence[HandView], contacts: Sequence[Contact], placed: Placed, finger: Finger) -> Tip:
    """The tip of a finger of a fitted hand.

    `contacts` are where the outlines of the views touch the hand. The tip's sphere may leave its place in the model by
    a few millimetres towards the outline pixels around it.
    """
    sphere = finger.sphere
    edges = [
        (v.projection, v.focal_px, v.outline, c.capsule, v.grey, v.shift) for v, c in zip(views, contacts, strict=True)
    ]
    padded = (*edges, *[NO_EDGES] * (MAX_VIEWS - len(edges)))
    tip = (placed.centres[sphere], placed.centres[sphere - 1], float(placed.radii[sphere]))
    shift, spread, seen = settle(padded, CAPSULES[:, 1] == sphere, tip, FREEDOM_M)
    point = placed.tip(sphere) + shift
    sight = np.mean([_sight(v.projection, point) for v in views], axis=0)
    return Tip(point, _covariance(finger, shift, spread, seen, sight), seen)


def _covariance(finger: Finger, shift: Array, spread: Array, seen: int, sight: Array) -> Array:
    """What the edges leave open (3, 3), and what no edge tells: shape, depth, what is hidden, and how far the hand
    differs from its model just here."""
    variance = SHAPE_SIGMA_M**2 + MISFIT_SHARE * float(shift @ shift) / 3
    if seen < MIN_VIEWS:
        variance += finger.hidden_sigmas_m[seen] ** 2
    depth = finger.depth_sigma_m**2 * np.outer(sight, sight)
    result: Array = finger.edges * spread + variance * np.eye(3) + depth
    return result


def _sight(projection: Array, point: Array) -> Array:
    """The unit vector (3,) from a camera to a point (3,)."""
    ahead = point + np.linalg.solve(projection[:, :3], projection[:, 3])
    result: Array = ahead / np.linalg.norm(ahead)
    return result

"""Finger tips on their own: a fitted tip moved to where its outline really lies, as no hand is quite the model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import MAX_VIEWS, MIN_VIEWS, Contact, Fit, HandView
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES
from local_site.tracking.silhouette.tip_edges import settle

FREEDOM_M = 0.008
SEEN_SIGMA_M, HIDDEN_SIGMA_M = 0.002, 0.005
NO_EDGES = (np.eye(3, 4), 1.0, np.empty((0, 2)), np.empty(0, np.intp), np.empty((0, 0), np.uint8), np.zeros(2))


@dataclass(frozen=True, slots=True)
class Tip:
    """A finger tip on the skin (3,), its covariance (3, 3) in m², and how many views show it in outline."""

    point: Array
    covariance: Array
    views: int


def find_tip(views: Sequence[HandView], contacts: Sequence[Contact], fit: Fit, covariance: Array, sphere: int) -> Tip:
    """The tip of the finger that ends in a sphere, for a fit with its covariance (16, 16).

    `contacts` are where the outlines of the views touch the hand. The tip's sphere may leave its place in the model by
    a few millimetres towards the outline pixels around it.
    """
    placed = fit.placed
    point, change = placed.tip(sphere)
    inherited = change @ covariance @ change.T
    edges = [
        (v.projection, v.focal_px, v.outline, c.capsule, v.grey, v.shift) for v, c in zip(views, contacts, strict=True)
    ]
    padded = (*edges, *[NO_EDGES] * (MAX_VIEWS - len(edges)))
    tip = (placed.centres[sphere], placed.centres[sphere - 1], float(placed.radii[sphere]))
    shift, spread, seen = settle(padded, CAPSULES[:, 1] == sphere, tip, FREEDOM_M)
    own_sigma = SEEN_SIGMA_M if seen >= MIN_VIEWS else HIDDEN_SIGMA_M
    return Tip(point + shift, spread + _unseen_part(inherited, spread) + own_sigma**2 * np.eye(3), seen)


def _unseen_part(inherited: Array, spread: Array) -> Array:
    """What of the model's own uncertainty the tip's outline leaves: all where it shows nothing."""
    left = spread / FREEDOM_M**2
    result: Array = left @ inherited @ left.T
    return result

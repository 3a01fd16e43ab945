"""Finger tips on their own: a fitted tip moved to where its outline really lies, as no hand is quite the model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import MIN_VIEWS, Contact, Fit, HandView
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES
from local_site.tracking.silhouette.tip_edges import add_grey_edges, add_outline_pixels

FREEDOM_M = 0.008
SEEN_SIGMA_M, HIDDEN_SIGMA_M = 0.002, 0.005
MIN_PIXELS = 3
STEPS = 3


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
    point, change = fit.placed.tip(sphere)
    inherited = change @ covariance @ change.T
    centre, before, radius = fit.placed.centres[sphere], fit.placed.centres[sphere - 1], fit.placed.radii[sphere]
    owned = [v.outline[CAPSULES[c.capsule, 1] == sphere] for v, c in zip(views, contacts, strict=True)]
    shift, information, seen = np.zeros(3), np.eye(3) / FREEDOM_M**2, 0
    for _ in range(STEPS):
        information, pull, seen = np.eye(3) / FREEDOM_M**2, shift / FREEDOM_M**2, 0
        for view, pixels in zip(views, owned, strict=True):
            tip = (centre + shift, before + shift, radius)
            if add_outline_pixels(view.projection, view.focal_px, pixels, tip, information, pull) >= MIN_PIXELS:
                seen += 1
            else:
                add_grey_edges(view.projection, view.focal_px, view.grey, view.shift, tip, information, pull)
        shift = shift - np.linalg.solve(information, pull)
    spread = np.linalg.inv(information).astype(np.float64)
    own_sigma = SEEN_SIGMA_M if seen >= MIN_VIEWS else HIDDEN_SIGMA_M
    return Tip(point + shift, spread + _unseen_part(inherited, spread) + own_sigma**2 * np.eye(3), seen)


def _unseen_part(inherited: Array, spread: Array) -> Array:
    """What of the model's own uncertainty the tip's outline leaves: all where it shows nothing."""
    left = spread / FREEDOM_M**2
    result: Array = left @ inherited @ left.T
    return result

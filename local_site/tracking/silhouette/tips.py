"""Finger tips on their own: a fitted tip moved to where its outline really lies, as no hand is quite the model."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.hand_model.fit import Fit, HandView, contact
from local_site.tracking.silhouette.hand_model.skeleton import CAPSULES

FREEDOM_M = 0.008
PIXEL_SIGMA = 1.7
REACH_PX = 3.0
CAP_BACK = 0.3
MIN_PIXELS = 4
STEPS = 3
EDGE_ANGLES = np.radians(np.arange(-75.0, 76.0, 15.0))
EDGE_STEPS = np.arange(-3.0, 3.1, 0.5)
EDGE_SIGMA = 2.5
MIN_EDGE = 0.08


@dataclass(frozen=True, slots=True)
class Tip:
    """A finger tip on the skin (3,), its covariance (3, 3) in m², and how many views show it in outline."""

    point: Array
    covariance: Array
    views: int


def find_tip(views: Sequence[HandView], fit: Fit, covariance: Array, sphere: int) -> Tip:
    """The tip of the finger that ends in a sphere, for a fit with its covariance (16, 16).

    The tip's sphere may leave its place in the model by a few millimetres towards the outline pixels around it.
    """
    point, change = fit.placed.tip(sphere)
    inherited = change @ covariance @ change.T
    owned = [_owned(view, fit, sphere) for view in views]
    shift, information, seen = np.zeros(3), np.eye(3) / FREEDOM_M**2, 0
    for _ in range(STEPS):
        information, pull, seen = np.eye(3) / FREEDOM_M**2, shift / FREEDOM_M**2, 0
        for view, pixels in zip(views, owned, strict=True):
            circle = _circle(view, fit, sphere, shift)
            rows, residuals = _on_outline(circle, pixels)
            if len(rows) >= MIN_PIXELS:
                seen += 1
            else:
                rows, residuals = _within(circle, view)
            information += rows.T @ rows
            pull += rows.T @ residuals
        shift = shift - np.linalg.solve(information, pull)
    spread = np.linalg.inv(information).astype(np.float64)
    return Tip(point + shift, spread + _unseen_part(inherited, spread), seen)


def _owned(view: HandView, fit: Fit, sphere: int) -> Array:
    """The outline pixels (N, 2) that no other part of the hand is nearer to."""
    own = CAPSULES[contact(view, fit.placed, view.outline).capsule, 1] == sphere
    result: Array = view.outline[own]
    return result


def _unseen_part(inherited: Array, spread: Array) -> Array:
    """What of the model's own uncertainty the tip's outline leaves: all where it shows nothing."""
    left = spread / FREEDOM_M**2
    result: Array = left @ inherited @ left.T
    return result


@dataclass(frozen=True, slots=True)
class _Circle:
    """A tip's sphere in a view: centre (2,) and radius in px, direction (2,) of the finger, px per m (2, 3)."""

    centre: Array
    radius: float
    ahead: Array
    gradient: Array


def _circle(view: HandView, fit: Fit, sphere: int, shift: Array) -> _Circle:
    m = view.projection
    (x, y, depth), (u, v, w) = (m[:, :3] @ (fit.placed.centres[k] + shift) + m[:, 3] for k in (sphere, sphere - 1))
    centre, back = np.array([x, y]) / depth, np.array([u, v]) / w
    ahead = (centre - back) / max(math.hypot(*(centre - back)), 1e-6)
    gradient = (m[:2, :3] - centre[:, None] * m[2, :3]) / depth
    return _Circle(centre, float(fit.placed.radii[sphere]) * view.focal_px / depth, ahead, gradient)


def _on_outline(circle: _Circle, pixels: Array) -> tuple[Array, Array]:
    """Rows (N, 3) and residuals (N,) in standard deviations of the outline pixels around a tip."""
    arms = pixels - circle.centre
    distance = np.maximum(np.hypot(arms[:, 0], arms[:, 1]), 1e-6)
    near = (np.abs(distance - circle.radius) < REACH_PX) & (arms @ circle.ahead > -CAP_BACK * circle.radius)
    normals = arms[near] / distance[near, None]
    return -normals @ circle.gradient / PIXEL_SIGMA, (distance[near] - circle.radius) / PIXEL_SIGMA


def _within(circle: _Circle, view: HandView) -> tuple[Array, Array]:
    """The same from edges of grey within the silhouette, where a finger ends before or beside another one."""
    c, s = np.cos(EDGE_ANGLES), np.sin(EDGE_ANGLES)
    a, b = circle.ahead
    normals = np.column_stack([c * a - s * b, s * a + c * b])
    reach = circle.radius + EDGE_STEPS
    x, y = (circle.centre[d] + normals[:, d, None] * reach for d in (0, 1))
    grey = cv2.remap(view.grey, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR).astype(np.float64)
    change = np.abs(grey[:, 2:] - grey[:, :-2])
    best = np.argmax(change, axis=1)
    clear = change[np.arange(len(best)), best] > MIN_EDGE * np.maximum(grey.max(axis=1), 1.0)
    residual = EDGE_STEPS[1:-1][best]
    return (-normals @ circle.gradient / EDGE_SIGMA)[clear], (residual / EDGE_SIGMA)[clear]

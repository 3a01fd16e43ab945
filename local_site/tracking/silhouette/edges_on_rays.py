"""Tips that one view shows in outline and the other only as an edge of grey, before or beside another finger."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.silhouette.candidates import Candidates, Places
from local_site.tracking.silhouette.features import Features

RAYS_PER_VIEW = 3
STEP = 0.012
REACH = 1.2
EDGE_STEPS = 2
MIN_FALL = 0.07
CLEAR_FALL = 0.3
EDGE_COST = 2.0
WEAK_EDGE_COST = 2.0


def edge_candidates(
    projections: Sequence[Array], features: Sequence[Features], places: Sequence[Places], wrist: Array, length: float
) -> Candidates:
    """Where the rays of the likeliest tips of either view leave a finger in the other view, outline or not.

    A finger before another one ends within the outline, where the grey falls in the direction away from the wrist (3,);
    `length` in m is the index's from the wrist.
    """
    found = [_of_view(projections, features, places, wrist, length, k) for k in range(2)]
    return found[0].joined(found[1])


def _of_view(
    projections: Sequence[Array],
    features: Sequence[Features],
    places: Sequence[Places],
    wrist: Array,
    length: float,
    view: int,
) -> Candidates:
    chosen = np.argsort(places[view].cost)[:RAYS_PER_VIEW]
    inverse = np.linalg.inv(projections[view][:, :3])
    centre = -inverse @ projections[view][:, 3]
    rays = np.column_stack([places[view].pixels[chosen], np.ones(len(chosen))]) @ inverse.T
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    along = (rays @ (wrist - centre))[:, None] + length * np.arange(-REACH, REACH, STEP)
    points = centre + along[..., None] * rays[:, None]
    falls = _falls(projections[1 - view], features[1 - view], points, wrist)
    row, at = _peaks(falls)
    fall = np.minimum(falls[row, at] / CLEAR_FALL, 1.0)
    cost = places[view].cost[chosen][row] + EDGE_COST + WEAK_EDGE_COST * (1 - fall)
    members = np.full((len(row), 2), -1)
    members[:, view] = chosen[row]
    return Candidates(points[row, at], cost, members)


def _falls(projection: Array, view: Features, points: Array, wrist: Array) -> Array:
    """The relative fall of grey (R, S) at points (R, S, 3), away from the wrist, 0 where it does not begin on skin."""
    pixels = project(projection, points)
    x, y = pixels.astype(np.float32).transpose(2, 0, 1)
    silhouette = view.silhouette
    grey = cv2.remap(silhouette.grey, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT).astype(np.float64)
    distance = np.hypot(*(pixels - project(projection, wrist)).transpose(2, 0, 1))
    k = EDGE_STEPS
    before, after = grey[:, : -2 * k], grey[:, 2 * k :]
    outward = distance[:, 2 * k :] > distance[:, : -2 * k]
    inner = np.where(outward, before, after)
    fall = np.where(outward, before - after, after - before) / np.maximum(inner, 1.0)
    result: Array = np.pad(np.where(inner > 1.5 * silhouette.level, fall, 0.0), ((0, 0), (k, k)))
    return result


def _peaks(falls: Array) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows and columns of the local maxima along the rows."""
    middle = falls[:, 1:-1]
    peak = (middle >= MIN_FALL) & (middle > falls[:, :-2]) & (middle >= falls[:, 2:])
    row, at = np.nonzero(peak)
    return row, at + 1

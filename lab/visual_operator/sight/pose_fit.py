"""The rough pose of a thing of known shape from its outlines in several calibrated views."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from common.geometry import Array, rotation_from_vector, transform
from lab.visual_operator.sight.outlines import UNITS, Outline

OUTLINE_SIGMA_PX = 0.5
MOST_SIGMAS = 3.0  # beyond which an outline that is partly covered counts less and less


@dataclass(frozen=True, slots=True)
class SeenOutline:
    """An outline and the projection (3, 4) of its view, from the frame in which the pose is wanted."""

    outline: Outline
    projection: Array


@dataclass(frozen=True, slots=True)
class Fitted:
    """A pose `frame_T_thing` (4 x 4), and the root mean square of what remains between outlines and shape, px."""

    pose: Array
    residual_px: float


def fit_pose(shape: Array, seen: Sequence[SeenOutline], expected: Array, sigmas: Array) -> Fitted:
    """The pose near the `expected` one (4 x 4) at which the shape (N, 3), m, has these outlines.

    `sigmas` (6,) say how surely the expected position (m) and rotation (rad, in the frame's axes) are known.
    """

    def residuals(change: Array) -> Array:
        pose = moved(expected, change * sigmas)
        misses = [_misses(shape, view, pose) / OUTLINE_SIGMA_PX for view in seen]
        return np.concatenate([*misses, change])

    found = least_squares(residuals, np.zeros(6), loss="soft_l1", f_scale=MOST_SIGMAS, max_nfev=25)
    pose = moved(expected, found.x * sigmas)
    misses = np.concatenate([_misses(shape, view, pose) for view in seen])
    return Fitted(pose, float(np.sqrt(np.mean(misses**2))))


def moved(pose: Array, change: Array) -> Array:
    """A pose (4 x 4) moved by (6,): m along, rad about the axes of its frame, turned about the thing's own origin."""
    return transform(rotation_from_vector(change[3:]) @ pose[:3, :3], pose[:3, 3] + change[:3])


def _misses(shape: Array, view: SeenOutline, pose: Array) -> Array:
    """Compute how much further the outline reaches than the shape, px, in all directions in which it is seen whole."""
    points = shape @ pose[:3, :3].T + pose[:3, 3]
    image = points @ view.projection[:, :3].T + view.projection[:, 3]
    pixels = image[:, :2] / np.maximum(image[:, 2:], 1e-6)
    misses = view.outline.reach - (pixels @ UNITS.T).max(axis=0)
    return np.where(np.isnan(misses), 0.0, misses)

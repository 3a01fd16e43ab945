"""The arm's outline in the picture as its meshes give it, for a pose that is still sought."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.lens import Lens
from local_site.tracking.monocular.arm_mesh import Profile
from local_site.tracking.monocular.pose import Link

INSIDE_PX = 1.0


@dataclass(frozen=True, slots=True)
class Sides:
    """Both sides of a link's outline: pixels (2, N, 2) of its sections, in order along the link."""

    pixels: Array

    @property
    def polygon(self) -> NDArray[np.float32]:
        """All of it once round (2N, 1, 2), as contours are told."""
        ring = np.concatenate([self.pixels[0], self.pixels[1, ::-1]])
        return ring.astype(np.float32)[:, None]

    def hides(self, points: Array) -> NDArray[np.bool_]:
        """Which pixels (..., 2) lie well inside of it."""
        polygon, places = self.polygon, points.reshape(-1, 2).tolist()
        inside = [cv2.pointPolygonTest(polygon, (x, y), True) > INSIDE_PX for x, y in places]
        return np.array(inside).reshape(points.shape[:-1])


def sides_of(profile: Profile, link: Link, lens: Lens) -> Sides:
    """Where the lines of sight touch a link's elliptic sections; a link seen from within has NaN.

    What the link's taper shifts these points along its skin moves the outline by less than a tenth of a pixel.
    """
    joint, rotation = link
    x, y, _ = (-rotation.T @ joint).tolist()
    across, deep = x / profile.across, y / profile.deep
    with np.errstate(invalid="ignore"):
        half = np.arccos(1.0 / np.hypot(across, deep))
    turns = np.arctan2(deep, across) + np.array([[-1.0], [1.0]]) * half
    along = np.broadcast_to(profile.along, turns.shape)
    points = np.stack([profile.across * np.cos(turns), profile.deep * np.sin(turns), along], axis=-1)
    in_camera = points @ rotation.T + joint
    return Sides(in_camera[..., :2] / in_camera[..., 2:] * (lens.fx, lens.fy) + (lens.cx, lens.cy))

"""The observation points of one link: learned from pictures where the mesh faces the camera, and kept.

The report takes them once, from the first picture. Here a link that rotates learns the part that comes into view, from
the picture and the estimated pose, so that it is not lost after half a turn. Earlier points stay unchanged, and correct
any drift when they come into view again.
"""

import math

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.monocular.arm_model import Depths, Link, Mesh
from local_site.tracking.monocular.equations import Surface

Mask = NDArray[np.bool_]

CELL_M = 0.0018
HIDDEN_BY_M = 0.006
SAMPLED = 6


class Skin:
    """Points (N, 3) in m and normals (N, 3) in the link's frame, with reflectances (N,) at fine and coarse level."""

    def __init__(self, mesh: Mesh, seed: int) -> None:
        self._random = np.random.default_rng(seed)
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        self._low = float(low[2])
        girth = 2.0 * math.pi * float(np.abs(np.concatenate([low[:2], high[:2]])).max())
        self._known = np.zeros((math.ceil((high[2] - low[2]) / CELL_M) + 1, math.ceil(girth / CELL_M)), np.bool_)
        self.points, self.normals = np.empty((0, 3)), np.empty((0, 3))
        self.fine, self.coarse = np.empty(0), np.empty(0)

    def surface_in_view(self, link: Link, depths: Depths, facing: float, most: int, is_coarse: bool) -> Surface:
        """At most `most` points that face the camera (-n.v > `facing`) and are not occluded, at one of the levels.

        They are spread over the visible part; if there are many more, only a regular sample is tested.
        """
        view = depths.focal, depths.principal, depths.inverse
        every = max(len(self.points) // (SAMPLED * most), 1)
        seen = np.flatnonzero(_in_view(self.points, self.normals, link, view, facing, every))
        seen = seen[:: max(len(seen) // most, 1)][:most]
        return Surface(self.points[seen], self.normals[seen], (self.coarse if is_coarse else self.fine)[seen])

    def unknown(self, points: Array) -> Mask:
        """Return which points (N, 3) in m of the link are not learned yet."""
        result: Mask = ~self._known[self._cells(points)]
        return result

    def learn(self, points: Array, normals: Array, fine: Array, coarse: Array) -> None:
        """Add new points with their reflectances, in random order so that any first part is spread evenly."""
        self._known[self._cells(points)] = True
        order = self._random.permutation(len(points))
        self.points = np.concatenate([self.points, points[order]])
        self.normals = np.concatenate([self.normals, normals[order]])
        self.fine = np.concatenate([self.fine, fine[order]])
        self.coarse = np.concatenate([self.coarse, coarse[order]])

    def _cells(self, points: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        rows, columns = self._known.shape
        along = ((points[:, 2] - self._low) / CELL_M).astype(np.intp).clip(0, rows - 1)
        turn = np.arctan2(points[:, 1], points[:, 0]) / (2.0 * math.pi) % 1.0
        return along, (turn * columns).astype(np.intp).clip(0, columns - 1)


@compiled
def _in_view(
    points: Array, normals: Array, link: tuple[Array, Array], view: tuple[Array, Array, Array], least: float, every: int
) -> Mask:
    """Find which points, of each `every`-th, are visible by the map of 1 / depth (H, W) in 1/m; outside it none is."""
    joint, rotation = link
    focal, principal, inverse_depth = view
    height, width = inverse_depth.shape
    seen = np.zeros(len(points), np.bool_)
    point, normal = np.empty(3), np.empty(3)
    for n in range(0, len(points), every):
        for k in range(3):
            point[k], normal[k] = joint[k], 0.0
            for i in range(3):
                point[k] += rotation[k, i] * points[n, i]
                normal[k] += rotation[k, i] * normals[n, i]
        x, y, z = point[0], point[1], point[2]
        towards = -(normal[0] * x + normal[1] * y + normal[2] * z)
        if z <= 0.0 or towards <= least * math.sqrt(x * x + y * y + z * z):
            continue
        column, row = int(focal[0] * x / z + principal[0] + 0.5), int(focal[1] * y / z + principal[1] + 0.5)
        if 0 <= column < width and 0 <= row < height:
            seen[n] = inverse_depth[row, column] * (z - HIDDEN_BY_M) <= 1.0
    return seen

"""The plate's discs in a picture, with subpixel centres, and which disc is which column and row of the lattice."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from common.cameras.camera import Image
from common.geometry import Array
from local_site.kernels.pictures import as_grey

GROUND_PART = 7
MIN_AREA_PX = 8
MIN_CONTRAST = 12.0
MAX_DISCS = 200
EDGE_PX, RING_PX = 2, 4
ELLIPSE_SLACK = 0.35


@dataclass(frozen=True, slots=True)
class Disc:
    """Centre of gravity (2,) in px and covariance (2, 2) in px² of a disc's picture, an ellipse."""

    centre: Array
    covariance: Array


def find_discs(picture: Image) -> list[Disc]:
    """All whole elliptic blobs that are brighter than their surroundings; blobs cut off by the border are left out."""
    grey = as_grey(picture)
    side = max(15, min(grey.shape) // GROUND_PART) | 1
    lifted = cv2.morphologyEx(grey, cv2.MORPH_TOPHAT, np.ones((side, side), np.uint8))
    threshold, mask = cv2.threshold(lifted, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    if threshold < MIN_CONTRAST:
        return []
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask)
    large = [k for k in range(1, count) if stats[k, cv2.CC_STAT_AREA] >= MIN_AREA_PX]
    large.sort(key=lambda k: -int(stats[k, cv2.CC_STAT_AREA]))
    found = [_measure(grey, labels, stats[k], k) for k in large[:MAX_DISCS]]
    return [disc for disc in found if disc is not None]


def _measure(grey: Image, labels: cv2.typing.MatLike, stats: cv2.typing.MatLike, label: int) -> Disc | None:
    """The blob as a disc, weighted with the part of each pixel that it covers; None if it is cut off or no ellipse."""
    left, top, width, height = (int(value) for value in stats[:4])
    if left == 0 or top == 0 or left + width == grey.shape[1] or top + height == grey.shape[0]:
        return None
    rows = slice(max(top - RING_PX - 1, 0), top + height + RING_PX + 1)
    columns = slice(max(left - RING_PX - 1, 0), left + width + RING_PX + 1)
    own = (labels[rows, columns] == label).astype(np.uint8)
    free = np.asarray((labels[rows, columns] == label) | (labels[rows, columns] == 0), dtype=np.bool_)
    weights = _weights(grey[rows, columns].astype(np.float64), own, free)
    v, u = np.nonzero(weights)
    w = weights[v, u]
    offsets = np.column_stack([u, v]).astype(np.float64)
    centre = w @ offsets / w.sum()
    covariance = (offsets - centre).T @ ((offsets - centre) * w[:, None]) / w.sum()
    ellipse = 4.0 * np.pi * float(np.sqrt(max(np.linalg.det(covariance), 0.0)))
    if not abs(float(w.sum()) / max(ellipse, 1e-9) - 1.0) < ELLIPSE_SLACK:
        return None
    return Disc(centre + np.array([columns.start, rows.start]), covariance)


def _weights(patch: Array, own: Image, free: NDArray[np.bool_]) -> Array:
    """Compute how much of each pixel is disc, from its grey between the ground's around and the disc's own."""
    near = _grown(own, EDGE_PX)
    ring = (_grown(own, RING_PX) > 0) & (near == 0) & free
    ground = float(np.median(patch[ring])) if np.any(ring) else float(patch.min())
    inside = patch[own > 0]
    bright = float(np.quantile(inside, 0.75))
    return np.clip((patch - ground) / max(bright - ground, 1.0), 0.0, 1.0) * ((near > 0) & free)


def _grown(mask: Image, by_px: int) -> Image:
    side = 2 * by_px + 1
    shape = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return np.asarray(cv2.dilate(mask, shape), dtype=np.uint8)


Cell = tuple[int, int]

STEPS: tuple[Cell, ...] = ((1, 0), (-1, 0), (0, 1), (0, -1))
GROW_SLACK, FIT_SLACK = 0.3, 0.2
MIN_CELLS = 6
MIN_PART = 0.85
ENOUGH = 0.9
FITS = 3
MAX_SEEDS = 40


@dataclass(frozen=True, slots=True)
class Lattice:
    """Cells (M, 2), as columns to the right and rows upwards in the picture, their pixels, the homography between."""

    cells: NDArray[np.int64]
    pixels: Array
    pixel_H_cell: Array

    @property
    def extent(self) -> Cell:
        """Return how many columns and rows it spans."""
        columns, rows = (np.ptp(self.cells, axis=0) + 1).tolist()
        return columns, rows

    def predicted(self, cells: Array) -> Array:
        """Pixels (N, 2) where cells (N, 2) would be seen."""
        return _mapped(self.pixel_H_cell, cells)


def find_lattice(discs: Sequence[Disc], size: Cell) -> Lattice | None:
    """The lattice of at most `size` columns and rows that takes in the most discs; None where there is none.

    A disc's ellipse gives the local foreshortening of the plate, so that the four nearest neighbours are
    known; from them the lattice grows, and a homography takes in the rest. Columns count to the right.
    """
    if len(discs) < MIN_CELLS:
        return None
    centres = np.array([disc.centre for disc in discs])
    middle = np.median(centres, axis=0)
    seeds = np.argsort(np.linalg.norm(centres - middle, axis=1))[:MAX_SEEDS]
    best: Lattice | None = None
    for seed in seeds:
        found = _grown_from(int(seed), discs, centres)
        lattice = _fitted(found, centres, size) if found else None
        if lattice is not None and (best is None or len(lattice.cells) > len(best.cells)):
            best = lattice
        if best is not None and len(best.cells) >= ENOUGH * len(discs):
            break
    return best


def _grown_from(seed: int, discs: Sequence[Disc], centres: Array) -> dict[int, Cell]:
    """Cells of the discs that can be reached from one of them step by step."""
    basis = _basis(discs[seed], centres)
    if basis is None:
        return {}
    cells: dict[int, Cell] = {seed: (0, 0)}
    taken = {(0, 0)}
    queue = deque([(seed, basis)])
    while queue:
        index, local = queue.popleft()
        away = np.linalg.solve(local, (centres - centres[index]).T).T
        for step in STEPS:
            misses = np.linalg.norm(away - step, axis=1)
            nearest = int(np.argmin(misses))
            cell = (cells[index][0] + step[0], cells[index][1] + step[1])
            if misses[nearest] > GROW_SLACK or nearest in cells or cell in taken:
                continue
            cells[nearest] = cell
            taken.add(cell)
            axis = 0 if step[0] else 1
            turned = local.copy()
            turned[:, axis] = (centres[nearest] - centres[index]) * (step[0] + step[1])
            queue.append((nearest, turned))
    return cells


def _basis(disc: Disc, centres: Array) -> Array | None:
    """The two steps of the lattice at a disc as columns (2, 2), px: nearest neighbours once its ellipse is a circle."""
    round_T = np.linalg.inv(np.linalg.cholesky(disc.covariance))
    away = centres - disc.centre
    flat = away @ round_T.T
    distances = np.linalg.norm(flat, axis=1)
    order = np.argsort(distances)[1:9]
    first = flat[order[0]] / distances[order[0]]
    for index in order[1:]:
        across = abs(float(first[0] * flat[index, 1] - first[1] * flat[index, 0])) / distances[index]
        if across > 0.7:
            return np.column_stack([away[order[0]], away[index]])
    return None


def _fitted(found: dict[int, Cell], centres: Array, size: Cell) -> Lattice | None:
    """The grown cells as a lattice with every disc that fits its homography, upright; None if it is not one."""
    indices, cells = list(found), np.array(list(found.values()), dtype=np.int64)
    homography: Array | None = None
    for _ in range(FITS):
        if len(indices) < MIN_CELLS or min(np.ptp(cells, axis=0)) < 1:
            return None
        fit = cv2.findHomography(cells.astype(np.float64), centres[indices], 0)[0]
        if fit is None:
            return None
        homography = np.asarray(fit, dtype=np.float64)
        exact = _mapped(np.asarray(np.linalg.inv(homography), dtype=np.float64), centres)
        whole = np.round(exact)
        near = np.all((whole >= cells.min(axis=0) - size) & (whole <= cells.max(axis=0) + size), axis=1)
        fits = near & (np.linalg.norm(exact - whole, axis=1) < FIT_SLACK)
        indices = _one_each(np.flatnonzero(fits), whole, exact)
        cells = whole[indices].astype(np.int64)
    if homography is None:
        return None
    lattice = _upright(cells, centres[indices], homography, size)
    return lattice if lattice is not None and len(lattice.cells) >= MIN_PART * len(cells) else None


def _one_each(candidates: NDArray[np.intp], whole: Array, exact: Array) -> list[int]:
    """Of several discs that claim a cell, the nearest."""
    nearest: dict[tuple[float, ...], int] = {}
    for index in sorted(candidates.tolist(), key=lambda k: float(np.linalg.norm(exact[k] - whole[k]))):
        nearest.setdefault(tuple(whole[index]), index)
    return list(nearest.values())


def _upright(cells: NDArray[np.int64], pixels: Array, pixel_H_cell: Array, size: Cell) -> Lattice | None:
    """The lattice with its columns to the right and its rows upwards, turned but never mirrored, cut to the plate."""
    middle = cells.mean(axis=0)
    ends = _mapped(pixel_H_cell, middle + 0.1 * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]))
    steps = np.column_stack([ends[1] - ends[0], ends[2] - ends[0]])
    choices = []
    swaps = (np.eye(2), np.eye(2)[::-1])
    for signs, swap in product(product((1.0, -1.0), repeat=2), swaps):  # the eight signed permutations of two axes
        turn = np.diag(signs) @ swap
        columns, rows = steps @ turn.T[:, 0], steps @ turn.T[:, 1]
        if columns[0] * rows[1] - columns[1] * rows[0] < 0:
            turned = np.round(cells @ turn.T).astype(np.int64)
            first, kept = _window(turned, size)
            right = float(columns[0] / np.linalg.norm(columns))
            choices.append((int(kept.sum()), right, turned[kept] - first, kept))
    _, _, upright, kept = max(choices, key=lambda choice: choice[:2])
    fit = cv2.findHomography(upright.astype(np.float64), pixels[kept], 0)[0]
    return None if fit is None else Lattice(upright, pixels[kept], np.asarray(fit, dtype=np.float64))


def _window(cells: NDArray[np.int64], size: Cell) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Find the best window of a plate's size: its least column and row (2,), and which of the cells (M, 2) it holds."""

    def held(first: tuple[int, ...]) -> NDArray[np.bool_]:
        inside: NDArray[np.bool_] = np.all((cells >= first) & (cells < np.add(first, size)), axis=1)
        return inside

    bounds = zip(cells.min(axis=0).tolist(), cells.max(axis=0).tolist(), size, strict=True)
    starts = [range(low, max(low, high - count + 1) + 1) for low, high, count in bounds]
    best = held(max(product(*starts), key=lambda first: int(held(first).sum())))
    return cells[best].min(axis=0), best


def _mapped(homography: Array, points: Array) -> Array:
    homogeneous = np.asarray(points, dtype=np.float64) @ homography[:, :2].T + homography[:, 2]
    return homogeneous[:, :2] / homogeneous[:, 2:]

"""A plate of discs at known heights: from its pictures to control points (thesis 3.2.9.1, figures 3.24-3.26)."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, product

import numpy as np

from common.cameras.camera import Image
from common.errors import CalibrationError
from common.geometry import Array
from local_site.calibration.control_points import CAMERAS, ControlPoints
from local_site.calibration.lattice import Cell, Disc, Lattice, find_discs, find_lattice
from local_site.calibration.resection import reprojection_errors, solve_projection, unsolvable

CLEARANCE = 1.5
CLEAR_CELLS = 2
AMBIGUOUS = 3.0
MAX_CHOICES = 1000


@dataclass(frozen=True, slots=True)
class Plate:
    """Discs in columns (along x) and rows (along y), their pitch and diameter in m; the thesis's plate by default."""

    columns: int = 5
    rows: int = 5
    pitch: float = 0.25
    diameter: float = 0.032

    @property
    def size(self) -> Cell:
        """Columns and rows."""
        return self.columns, self.rows


@dataclass(frozen=True, slots=True)
class PlateView:
    """One picture's lattice, and the plate's columns and rows at which the lattice may begin."""

    lattice: Lattice
    beginnings: tuple[Cell, ...]
    size_px: tuple[int, int]


def view_plate(picture: Image, plate: Plate, name: str) -> PlateView:
    """Find and order the discs of a picture; CalibrationError, with the cure, where there is no lattice."""
    discs = find_discs(picture)
    lattice = find_lattice(discs, plate.size)
    if lattice is None:
        raise CalibrationError(
            f"{name}: {len(discs)} discs found, but no lattice of {plate.columns} x {plate.rows}; light the plate "
            "evenly, keep other bright things out of the picture, and give its true columns and rows with --discs"
        )
    size_px = (picture.shape[1], picture.shape[0])
    beginnings = _beginnings(lattice, discs, plate, size_px)
    if not beginnings:
        columns, rows = lattice.extent
        raise CalibrationError(
            f"{name}: the plate ends after {columns} x {rows} discs, not {plate.columns} x {plate.rows}; uncover all "
            "of its discs, or give its true columns and rows with --discs"
        )
    return PlateView(lattice, beginnings, size_px)


def plate_control_points(views: Sequence[Sequence[PlateView]], heights: Sequence[float], plate: Plate) -> ControlPoints:
    """Control points from each camera's views of the plate, one per height in m.

    Raises CalibrationError if the pictures do not show which part of the plate they see.
    """
    chosen = [_choose(name, seen, heights) for name, seen in zip(CAMERAS, views, strict=False)]
    cells = [(i, j, k) for k in range(len(heights)) for j in range(plate.rows) for i in range(plate.columns)]
    index_of = {cell: index for index, cell in enumerate(cells)}
    pixels = []
    for seen, beginnings in zip(views, chosen, strict=True):
        found = np.full((len(cells), 2), np.nan)
        for k, (view, begin) in enumerate(zip(seen, beginnings, strict=True)):
            for (i, j), pixel in zip((view.lattice.cells + begin).tolist(), view.lattice.pixels, strict=True):
                found[index_of[i, j, k]] = pixel
        pixels.append(found)
    points = np.array([(i * plate.pitch, j * plate.pitch, heights[k]) for i, j, k in cells])
    labels = tuple(f"disc column {i + 1}, row {j + 1} at {1e3 * heights[k]:g} mm" for i, j, k in cells)
    sizes = tuple(seen[0].size_px for seen in views)
    return ControlPoints(points, tuple(pixels), labels, "the plate", sizes)


def without_perspective_bias(control: ControlPoints, projections: Sequence[Array], diameter: float) -> ControlPoints:
    """The control points with the pixels of the discs' centres, not of their ellipses'; diameter in m.

    A circle's picture is an ellipse whose centre lies off the picture of the circle's centre; how far follows from the
    projections (3, 4) of a first solution. The discs are level.
    """
    moved = []
    for projection, pixels in zip(projections, control.pixels, strict=True):
        offsets = [_ellipse_offset(projection, point, diameter / 2) for point in control.points]
        moved.append(pixels - np.array(offsets))
    return ControlPoints(control.points, tuple(moved), control.labels, control.source, control.sizes)


def _ellipse_offset(projection: Array, centre: Array, radius: float) -> Array:
    """From the picture of a level circle's centre (3,) to the centre of the circle's picture, px (2,)."""
    x, y, z = centre
    world_T_circle = np.array([[radius, 0.0, x], [0.0, radius, y], [0.0, 0.0, z], [0.0, 0.0, 1.0]])
    pixel_H_circle = projection @ world_T_circle
    dual = pixel_H_circle @ np.diag([1.0, 1.0, -1.0]) @ pixel_H_circle.T
    middle = pixel_H_circle[:, 2]
    offset: Array = dual[:2, 2] / dual[2, 2] - middle[:2] / middle[2]
    return offset


def _beginnings(lattice: Lattice, discs: Sequence[Disc], plate: Plate, size_px: tuple[int, int]) -> tuple[Cell, ...]:
    """The plate's cells at which the lattice may begin: it ends where a further line of discs would be visible."""
    spans: list[list[int]] = []
    for axis, (extent, whole) in enumerate(zip(lattice.extent, plate.size, strict=True)):
        possible = set(range(whole - extent + 1))
        if _ends(lattice, discs, axis, -1, size_px):
            possible &= {0}
        if _ends(lattice, discs, axis, extent, size_px):
            possible &= {whole - extent}
        spans.append(sorted(possible))
    return tuple((column, row) for column in spans[0] for row in spans[1])


def _ends(lattice: Lattice, discs: Sequence[Disc], axis: int, line: int, size_px: tuple[int, int]) -> bool:
    """Return whether discs of a line beyond the lattice would lie well inside the picture."""
    along = np.arange(lattice.extent[1 - axis])
    cells = np.column_stack([np.full(len(along), line), along] if axis == 0 else [along, np.full(len(along), line)])
    reach = CLEARANCE * 2.0 * np.sqrt(np.max([np.diag(disc.covariance) for disc in discs], axis=0))
    pixels = lattice.predicted(cells)
    inside = np.all((pixels > reach) & (pixels < np.array(size_px) - 1 - reach), axis=1)
    return int(np.sum(inside)) >= min(CLEAR_CELLS, len(along))


def _choose(name: str, views: Sequence[PlateView], heights: Sequence[float]) -> tuple[Cell, ...]:
    """The beginnings with which one camera explains all heights."""
    choices = list(islice(product(*(view.beginnings for view in views)), MAX_CHOICES + 1))
    if len(choices) == 1:
        return choices[0]
    ranked = sorted((_misfit(views, heights, choice), choice) for choice in choices[:MAX_CHOICES])
    if len(choices) > MAX_CHOICES or ranked[1][0] < AMBIGUOUS * ranked[0][0]:
        raise CalibrationError(
            f"{name} camera: its pictures do not determine which of the plate's discs they show; let each picture "
            "show an end of the plate's columns and an end of its rows"
        )
    return ranked[0][1]


def _misfit(views: Sequence[PlateView], heights: Sequence[float], beginnings: Sequence[Cell]) -> float:
    """The rms residual in px of a camera that sees the plate so; the pitch is irrelevant to it."""
    levels = np.array(heights) / max(float(np.ptp(heights)), 1e-9)
    cells = [view.lattice.cells + begin for view, begin in zip(views, beginnings, strict=True)]
    points = np.concatenate([np.column_stack([c, np.full(len(c), h)]) for c, h in zip(cells, levels, strict=True)])
    if unsolvable(points):
        return 0.0
    pixels = np.concatenate([view.lattice.pixels for view in views])
    return float(np.sqrt(np.mean(reprojection_errors(solve_projection(points, pixels), points, pixels) ** 2)))

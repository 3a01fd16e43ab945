"""A box of the tool centre point all of which the arm reaches, with the tool as at the start; pure."""

import itertools
import math
from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.geometry import Array, transform
from farhand.arm_import.choices.reaching import WORST_CONDITION, Reaching
from remote_site.safety.config import CollisionConfig

POINTS = 12  # of the grid over the reach
LOWEST_M = 0.03
NEAR_M = CollisionConfig().slow_m
LEAST_DISTANCE_M = 0.0115  # a little more than is always kept
# What an operator's hand moves in front of him, from the start, m: forward, to the left, up.
ROOM_M = ((-0.08, 0.0, 0.14), (-0.22, -0.11, 0.0, 0.11, 0.22), (-0.18, -0.09, 0.0, 0.12))
LEAST_ROOM_RAD = 0.05
Cell = tuple[int, int, int]
STEPS: tuple[Cell, ...] = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Places by their numbers along each axis, m; those from cell `first` to cell `last` are the hand's room."""

    axes: tuple[Array, Array, Array]
    start: Cell
    first: Cell
    last: Cell

    @classmethod
    def around(cls, place: Array, reach_m: float, scale: float) -> "Grid":
        """Over all that is before the base and above the table, around the hand's room, `scale` times as large."""
        low = (0.05 * reach_m, -0.8 * reach_m, LOWEST_M)
        high = (0.95 * reach_m, 0.8 * reach_m, 0.85 * reach_m)
        rows, before = [], []
        for at, room, least, most in zip(place.tolist(), ROOM_M, low, high, strict=True):
            own = [at + scale * offset for offset in room]
            down = np.arange(own[0], least - 1e-9, -reach_m / POINTS)[:0:-1]
            up = np.arange(own[-1], most + 1e-9, reach_m / POINTS)[1:]
            rows.append(np.concatenate([down, own, up]))
            before.append(len(down))
        start, first, last = (
            tuple(n + k for n, k in zip(before, inside, strict=True))
            for inside in ([room.index(0.0) for room in ROOM_M], (0, 0, 0), [len(room) - 1 for room in ROOM_M])
        )
        return cls((rows[0], rows[1], rows[2]), _cell(start), _cell(first), _cell(last))

    def at(self, cell: Cell) -> Array:
        """The place (3,) in m."""
        return np.array([axis[k] for axis, k in zip(self.axes, cell, strict=True)])

    @property
    def size(self) -> Cell:
        """The number of places along each axis."""
        return _cell(tuple(len(axis) for axis in self.axes))


@dataclass(frozen=True, slots=True, eq=False)
class ReachedBox:
    """Its lower and upper corner (3,) in m; `near_m` is the least distance, in the hand's room, of the bodies that
    already are near each other at the start, inf where none are."""

    low: Array
    high: Array
    near_m: float

    @property
    def volume(self) -> float:
        """m³."""
        return float(np.prod(self.high - self.low))


def choose_box(reaching: Reaching, start_q: Array, reach_m: float, scale: float) -> ReachedBox | None:
    """The largest box in which every place of a grid is reached from the start, the hand's room included.

    None where it is not all of this room, `scale` times as large.
    """
    pose = reaching.model.forward(start_q)
    grid = Grid.around(pose[:3, 3], reach_m, scale)
    if grid.at(grid.first)[2] < LOWEST_M:
        return None
    flood = _Flood(reaching, grid, start_q, pose[:3, :3])
    flood.fill(grid.first, grid.last)
    if not flood.reached[_slices(grid.first, grid.last)].all():
        return None
    near_m = flood.least_distance()
    flood.fill((0, 0, 0), _cell(tuple(n - 1 for n in grid.size)))
    low, high = largest_box(flood.reached, grid)
    return ReachedBox(grid.at(low), grid.at(high), near_m)


class _Flood:
    """Which places the arm comes to from the start, from each to the next; nearly singular ones do not count."""

    def __init__(self, reaching: Reaching, grid: Grid, start_q: Array, base_R_tool: Array) -> None:
        self._reaching, self._grid, self._base_R_tool = reaching, grid, base_R_tool
        self.reached = np.zeros(grid.size, dtype=bool)
        self.reached[grid.start] = True
        self._start_q = start_q
        self._postures: dict[Cell, Array] = {grid.start: start_q}

    def fill(self, first: Cell, last: Cell) -> None:
        """Everything between two cells that can be reached from what has been."""
        waiting = deque(self._postures)
        while waiting:
            cell = waiting.popleft()
            for step in STEPS:
                after = _cell(tuple(a + b for a, b in zip(cell, step, strict=True)))
                inside = all(a <= k <= b for a, k, b in zip(first, after, last, strict=True))
                if inside and after not in self._postures and self._reach(after, self._postures[cell]):
                    waiting.append(after)

    def least_distance(self) -> float:
        """So far, of the bodies that are near each other at the start, m."""
        collision = self._reaching.collision
        near = np.flatnonzero(collision.distances(self._start_q) < NEAR_M)
        return min(float(collision.distances(q, near).min(initial=math.inf)) for q in self._postures.values())

    def _reach(self, cell: Cell, q: Array) -> bool:
        there = self._reaching.towards(transform(self._base_R_tool, self._grid.at(cell)), q, self._start_q)
        if there is None or not _good(self._reaching, there):
            return False
        self._postures[cell] = there
        self.reached[cell] = True
        return True


def _good(reaching: Reaching, q: Array) -> bool:
    quality = reaching.quality(q)
    return (
        quality.condition <= WORST_CONDITION
        and quality.distance_m >= LEAST_DISTANCE_M
        and quality.room_rad >= LEAST_ROOM_RAD
    )


def largest_box(reached: NDArray[np.bool_], grid: Grid) -> tuple[Cell, Cell]:
    """The first and the last cell of the largest box around the hand's room that is all True."""
    sums = np.pad(reached.astype(int), ((1, 0), (1, 0), (1, 0))).cumsum(0).cumsum(1).cumsum(2)
    best, chosen = 0.0, (grid.first, grid.last)
    ends = zip(grid.first, grid.last, grid.size, strict=True)
    spans = [list(itertools.product(range(first + 1), range(last, n))) for first, last, n in ends]
    for (x0, x1), (y0, y1), (z0, z1) in itertools.product(*spans):
        low, high = (x0, y0, z0), (x1, y1, z1)
        volume = float(np.prod(grid.at(high) - grid.at(low)))
        cells = (x1 - x0 + 1) * (y1 - y0 + 1) * (z1 - z0 + 1)
        if volume > best and _count(sums, low, (x1 + 1, y1 + 1, z1 + 1)) == cells:
            best, chosen = volume, (low, high)
    return chosen


def _slices(first: Cell, last: Cell) -> tuple[slice, slice, slice]:
    x, y, z = (slice(a, b + 1) for a, b in zip(first, last, strict=True))
    return x, y, z


def _cell(numbers: tuple[int, ...]) -> Cell:
    x, y, z = numbers
    return x, y, z


def _count(sums: NDArray[np.int_], low: Cell, high: Cell) -> int:
    """Count the cells that are True from `low` up to, but not at, `high`."""
    (a, b, c), (d, e, f) = low, high
    return int(
        sums[d, e, f]
        - sums[a, e, f]
        - sums[d, b, f]
        - sums[d, e, c]
        + sums[a, b, f]
        + sums[a, e, c]
        + sums[d, b, c]
        - sums[a, b, c]
    )

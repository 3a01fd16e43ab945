"""The forearm and the upper arm as tubes: directions in which all views together look most like the arm."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import focal_length, project
from local_site.kernels.compiled import compiled
from local_site.tracking.features.posture import Posture
from local_site.tracking.foreground.likelihood import LogRatios

# Of an average adult; all lengths are scaled with the hand's.
FOREARM_M, FOREARM_HALF_WIDTHS_M = 0.265, (0.028, 0.042)
UPPER_ARM_M, UPPER_ARM_HALF_WIDTHS_M = 0.25, (0.042, 0.055)
STATIONS = 12
INSIDE, OUTSIDE = (-0.75, -0.375, 0.0, 0.375, 0.75), (-1.7, -1.35, 1.35, 1.7)
OUTSIDE_WEIGHT = 0.6
ALL_ROUND, NEAR, NEARER = 600, 120, 80
NEAR_ANGLE, NEARER_ANGLE = math.radians(25.0), math.radians(8.0)
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True, slots=True)
class RatioMap:
    """Log ratios (h, w) of squares of one view: the px of the first square's corner, the squares' side in px."""

    projection: Array
    ratios: LogRatios
    left: int
    top: int
    stride: int

    @property
    def place(self) -> tuple[int, int, int]:
        """Left and top in px, and the stride."""
        return self.left, self.top, self.stride

    def to_squares(self, pixels: Array) -> Array:
        """Positions (..., 2) in squares, whole numbers at their middles, of pixels (..., 2)."""
        result: Array = (pixels - (self.left, self.top) + 0.5) / self.stride - 0.5
        return result


@dataclass(frozen=True, slots=True)
class Tube:
    """A limb from one point (3,) to another in m, its half widths in m at both ends, and how well the views show it.

    `scores` are by view: the mean log ratio inside, less a part of that beside it.
    """

    start: Array
    end: Array
    half_widths: tuple[float, float]
    scores: tuple[float, ...]

    @property
    def direction(self) -> Array:
        """The unit vector (3,) from start to end."""
        along = self.end - self.start
        result: Array = along / max(float(np.linalg.norm(along)), 1e-9)
        return result

    def moved(self, start: Array) -> "Tube":
        """The tube from another start (3,)."""
        return Tube(start, self.end + start - self.start, self.half_widths, self.scores)


@dataclass(frozen=True, slots=True)
class ArmTubes:
    """Where forearm and upper arm are, roughly: the elbow within some centimetres."""

    forearm: Tube
    upper_arm: Tube

    def posture(self, projection: Array, hand_end: Array) -> Posture:
        """The posture in a view, with the hand's end (2,) in px."""
        points = np.array([self.upper_arm.end, self.forearm.end, self.forearm.start])
        shoulder_end, elbow, wrist = project(projection, points)
        half_width_px = self.forearm.half_widths[1] * px_per_m(projection, self.forearm.end)
        return Posture(shoulder_end, elbow, wrist, hand_end, half_width_px)


def px_per_m(projection: Array, point: Array) -> float:
    """How many px a metre across the view has at a point (3,) in m."""
    depth = float(projection[2, :3] @ point + projection[2, 3])
    return focal_length(projection) / max(depth, 1e-6)


def find_tube(maps: Sequence[RatioMap], like: Tube, axis: Array, most_angle: float, last: Array | None) -> Tube:
    """The tube in place of `like` that the views show best, with its direction within an angle in rad of an axis (3,).

    It is searched all round, or near the last direction (3,).
    """
    first = cap(axis, most_angle, ALL_ROUND) if last is None else cap(last, NEAR_ANGLE, NEAR)
    best = _best(maps, like, first)
    return _best(maps, best, cap(best.direction, NEARER_ANGLE, NEARER))


def _best(maps: Sequence[RatioMap], like: Tube, directions: Array) -> Tube:
    ends = like.start + float(np.linalg.norm(like.end - like.start)) * directions
    scores = np.array(
        [_scores(m.projection, m.ratios, m.place, like.start, ends, half_widths_px(m, like)) for m in maps]
    )
    k = int(np.argmax(scores.sum(axis=0)))
    return Tube(like.start, ends[k], like.half_widths, tuple(scores[:, k].tolist()))


def half_widths_px(view: RatioMap, tube: Tube) -> tuple[float, float]:
    """A tube's half widths in px at depth 1."""
    focal_px = focal_length(view.projection)
    return focal_px * tube.half_widths[0], focal_px * tube.half_widths[1]


def cap(axis: Array, most_angle: float, count: int) -> Array:
    """Unit vectors (count, 3) spread evenly within an angle in rad of an axis (3,); the first is the axis."""
    n = np.arange(count)
    z = 1.0 - (1.0 - math.cos(most_angle)) * n / max(count - 1, 1)
    radius = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    side = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    side /= np.linalg.norm(side)
    other = np.cross(axis, side)
    angle = GOLDEN_ANGLE * n
    spread: Array = (
        z[:, None] * axis + (radius * np.cos(angle))[:, None] * side + (radius * np.sin(angle))[:, None] * other
    )
    return spread


@compiled
def _scores(
    projection: Array,
    ratios: LogRatios,
    place: tuple[int, int, int],
    start: Array,
    ends: Array,
    half_widths_px: tuple[float, float],
) -> Array:
    """How well tubes from a start (3,) to ends (N, 3) fit one view, (N,); what lies beyond the map counts as 0.

    `half_widths_px` are those at depth 1.
    """
    scores = np.zeros(len(ends))
    a = _homogeneous(projection, start)
    for n in range(len(ends)):
        b = _homogeneous(projection, ends[n])
        if a[2] <= 0.0 or b[2] <= 0.0:
            continue
        dx, dy = b[0] / b[2] - a[0] / a[2], b[1] / b[2] - a[1] / a[2]
        length = max(math.sqrt(dx * dx + dy * dy), 1e-6)
        for k in range(STATIONS):
            t = (k + 1.0) / STATIONS
            depth = a[2] + t * (b[2] - a[2])
            half = (half_widths_px[0] + t * (half_widths_px[1] - half_widths_px[0])) / depth
            x, y = (a[0] + t * (b[0] - a[0])) / depth, (a[1] + t * (b[1] - a[1])) / depth
            step = (-half * dy / length, half * dx / length)
            scores[n] += _across(ratios, place, (x, y), step) / STATIONS
    return scores


@compiled
def _across(
    ratios: LogRatios, place: tuple[int, int, int], middle: tuple[float, float], step: tuple[float, float]
) -> float:
    """The mean log ratio of a tube's section, less a part of that beside it; `step` px lead from the middle to a side."""
    left, top, stride = place
    total = 0.0
    for offset in INSIDE + OUTSIDE:
        i = math.floor((middle[0] + offset * step[0] - left) / stride)
        j = math.floor((middle[1] + offset * step[1] - top) / stride)
        if 0 <= i < ratios.shape[1] and 0 <= j < ratios.shape[0]:
            is_inside = -1.0 < offset < 1.0
            total += ratios[j, i] * (1.0 / len(INSIDE) if is_inside else -OUTSIDE_WEIGHT / len(OUTSIDE))
    return total


@compiled
def _homogeneous(projection: Array, point: Array) -> tuple[float, float, float]:
    x, y, z = point
    a, b, c = projection[0], projection[1], projection[2]
    return (
        a[0] * x + a[1] * y + a[2] * z + a[3],
        b[0] * x + b[1] * y + b[2] * z + b[3],
        c[0] * x + c[1] * y + c[2] * z + c[3],
    )

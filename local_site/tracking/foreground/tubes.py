"""What the search for the limbs takes and gives: maps of log ratios, and tubes in the operator frame."""

from dataclasses import dataclass

import numpy as np

from common.geometry import Array
from local_site.calibration.triangulation import focal_length, project
from local_site.kernels.compiled import compiled
from local_site.tracking.features.posture import Posture
from local_site.tracking.foreground.likelihood import LogRatios

LEAST_DEPTH_M = 1e-3


@dataclass(frozen=True, slots=True)
class RatioMap:
    """Log ratios (h, w) of squares of one view: the px of the first square's corner, the squares' side in px.

    `projection` (3, 4) and `focal_px` are the view's.
    """

    projection: Array
    focal_px: float
    ratios: LogRatios
    left: int
    top: int
    stride: int

    @property
    def place(self) -> tuple[int, int, int]:
        """Left and top in px, and the stride."""
        return self.left, self.top, self.stride

    def squares_per_m(self, point: Array) -> float:
        """How many squares a metre across the view has at a point (3,) in m."""
        return self.focal_px / (self.stride * depth_of(self.projection, point))

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

    @property
    def score(self) -> float:
        """How well all views show it together."""
        return sum(self.scores)

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
        half_width_px = self.forearm.half_widths[1] * focal_length(projection) / depth_of(projection, self.forearm.end)
        return Posture(shoulder_end, elbow, wrist, hand_end, half_width_px)


def depth_of(projection: Array, point: Array) -> float:
    """The depth in m of a point (3,) in m in a view, a millimetre at least."""
    return max(float(projection[2, :3] @ point + projection[2, 3]), LEAST_DEPTH_M)


@compiled
def homogeneous(projection: Array, point: Array) -> tuple[float, float, float]:
    """The homogeneous pixel of a point (3,) in m by a projection (3, 4); the last number is its depth in m."""
    x, y, z = point
    a, b, c = projection[0], projection[1], projection[2]
    return (
        a[0] * x + a[1] * y + a[2] * z + a[3],
        b[0] * x + b[1] * y + b[2] * z + b[3],
        c[0] * x + c[1] * y + c[2] * z + c[3],
    )

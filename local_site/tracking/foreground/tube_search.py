"""The search for forearm and upper arm: directions in which all views together look most like the arm."""

import math
from collections.abc import Sequence

import numpy as np

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.foreground.likelihood import LogRatios
from local_site.tracking.foreground.tubes import ArmTubes, RatioMap, Tube, homogeneous

# Of adults, from the wrist's landmark on: the part of the forearm that everybody has, where the elbow can be, how far
# the path along both limbs is looked at, and their half widths at wrist, elbow and shoulder.
SURE_M, PATH_M = 0.20, 0.45
ELBOWS_M = (0.22, 0.25, 0.28, 0.31)
WRIST_HALF_M, ELBOW_HALF_M, SHOULDER_HALF_M = 0.028, 0.042, 0.052
STATIONS = 12
INSIDE, OUTSIDE = (-0.75, -0.375, 0.0, 0.375, 0.75), (-1.7, -1.35, 1.35, 1.7)
OUTSIDE_WEIGHT = 0.6
FOREARM_ANGLE, UPPER_ARM_ANGLE = math.radians(95.0), math.radians(110.0)
ALL_ROUND, NEAR, NEARER, ELSEWHERE = 600, 100, 60, 60
UPPER_ALL_ROUND, UPPER_NEAR, UPPER_ELSEWHERE = 150, 40, 20
NEAR_ANGLE, NEARER_ANGLE = math.radians(25.0), math.radians(8.0)
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


class TubeSearch:
    """Finds forearm and upper arm: at first all round, then near the last, with some looks elsewhere."""

    def __init__(self) -> None:
        self._last: ArmTubes | None = None
        self._spin = 0.0

    def expected(self, wrist: Array) -> ArmTubes | None:
        """The limbs as they were last, at a wrist (3,) in m; None at first."""
        if self._last is None:
            return None
        forearm = self._last.forearm.moved(wrist)
        return ArmTubes(forearm, self._last.upper_arm.moved(forearm.end))

    def forget(self) -> None:
        """Search all round next time."""
        self._last = None

    def find(self, maps: Sequence[RatioMap], wrist: Array, axis: Array) -> ArmTubes:
        """The limbs that the views show best from a wrist (3,) on; `axis` (3,) leads from the knuckles to the wrist."""
        self._spin += GOLDEN_ANGLE
        if self._last is None:
            directions = cap(axis, FOREARM_ANGLE, ALL_ROUND)
        else:
            near = cap(self._last.forearm.direction, NEAR_ANGLE, NEAR, self._spin)
            directions = np.vstack([near, cap(axis, FOREARM_ANGLE, ELSEWHERE, self._spin)])
        best = _best(maps, wrist, SURE_M * _bendable(directions, axis), (WRIST_HALF_M, ELBOW_HALF_M))
        closer = _bendable(cap(best.direction, NEARER_ANGLE, NEARER, self._spin), axis)
        best = _best(maps, wrist, SURE_M * closer, best.half_widths)
        self._last = self._with_elbow(maps, best)
        return self._last

    def _with_elbow(self, maps: Sequence[RatioMap], sure: Tube) -> ArmTubes:
        """Both limbs, with the elbow where the arm bends."""
        uppers = self._uppers(sure)
        return max((_arm(maps, sure, length, uppers) for length in ELBOWS_M), key=_path_score)

    def _uppers(self, forearm: Tube) -> Array:
        if self._last is None:
            return cap(forearm.direction, UPPER_ARM_ANGLE, UPPER_ALL_ROUND)
        near = cap(self._last.upper_arm.direction, NEAR_ANGLE, UPPER_NEAR, self._spin)
        return np.vstack([near, cap(forearm.direction, UPPER_ARM_ANGLE, UPPER_ELSEWHERE, self._spin)])


def _arm(maps: Sequence[RatioMap], sure: Tube, length: float, uppers: Array) -> ArmTubes:
    """Both limbs with a forearm of this length in m, and an upper arm in one of the directions (N, 3)."""
    forearm = _best(maps, sure.start, length * sure.direction[None], sure.half_widths)
    return ArmTubes(forearm, _best(maps, forearm.end, (PATH_M - length) * uppers, (ELBOW_HALF_M, SHOULDER_HALF_M)))


def _path_score(tubes: ArmTubes) -> float:
    """How well the views show both limbs, each counted by its length."""
    return sum(float(np.linalg.norm(tube.end - tube.start)) * tube.score for tube in (tubes.forearm, tubes.upper_arm))


def _bendable(directions: Array, axis: Array) -> Array:
    """Those of the directions (N, 3) to which a wrist can bend from an axis (3,); the axis where there are none."""
    kept = directions[directions @ axis > math.cos(FOREARM_ANGLE)]
    return kept if len(kept) else axis[None]


def _best(maps: Sequence[RatioMap], start: Array, ways: Array, half_widths: tuple[float, float]) -> Tube:
    """The tube from a start (3,) by one of the ways (N, 3) in m that the views show best."""
    ends = start + ways
    wrist, elbow = half_widths
    scores = np.array(
        [_scores(m.projection, m.ratios, m.place, start, ends, (m.focal_px * wrist, m.focal_px * elbow)) for m in maps]
    )
    k = int(np.argmax(scores.sum(axis=0)))
    return Tube(start, ends[k], half_widths, tuple(scores[:, k].tolist()))


def cap(axis: Array, most_angle: float, count: int, spin: float = 0.0) -> Array:
    """Unit vectors (count, 3) spread evenly within an angle in rad of an axis (3,); the first is the axis."""
    n = np.arange(count)
    z = 1.0 - (1.0 - math.cos(most_angle)) * n / max(count - 1, 1)
    radius = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    x, y, w = axis.tolist()
    side = np.array([0.0, -w, y] if abs(x) < 0.6 else [w, 0.0, -x])
    side /= math.hypot(*side)
    other = np.array([y * side[2] - w * side[1], w * side[0] - x * side[2], x * side[1] - y * side[0]])
    angle = GOLDEN_ANGLE * n + spin
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
    a = homogeneous(projection, start)
    for n in range(len(ends)):
        b = homogeneous(projection, ends[n])
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
    """The mean log ratio of a tube's section, less a part of that beside it; `step` in px is half its width."""
    left, top, stride = place
    total = 0.0
    for offset in INSIDE + OUTSIDE:
        i = math.floor((middle[0] + offset * step[0] - left) / stride)
        j = math.floor((middle[1] + offset * step[1] - top) / stride)
        if 0 <= i < ratios.shape[1] and 0 <= j < ratios.shape[0]:
            is_inside = -1.0 < offset < 1.0
            total += ratios[j, i] * (1.0 / len(INSIDE) if is_inside else -OUTSIDE_WEIGHT / len(OUTSIDE))
    return total

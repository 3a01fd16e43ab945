"""The arm's features in one image: medial lines, wrist, hand, all in pixels.

Rows of a limb are positions t (R,) in px along its axis and the edges' offsets (R,) across it, NaN where an edge is not
seen.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from common.geometry import Array
from local_site.kernels.compiled import compiled
from local_site.tracking.features.medial import (
    Edges,
    MedialLine,
    limb_sides,
    line_through,
    medial_line,
    scan_edges,
    typical_width,
)
from local_site.tracking.features.posture import Posture, find_posture
from local_site.tracking.features.silhouette import Silhouette

FOREARM_RANGE = (0.3, 0.92)
ROOT_START, ROOT_LENGTH = 0.2, 0.2
MIN_ROOT_ROWS = 4
FOREARM_SIDES, UPPER_ARM_SIDES = (0.0, 0.6), (0.3, 1.0)
UPPER_ARM_START, LEAST_UPPER_ARM = 0.6, 0.7  # half widths; of less, the line points anywhere
MAX_CREASE_COSINE = 0.87
REFITS = 1
MAX_TURN = math.radians(40.0)
MIN_VALID = 0.7
SAME_LIMB_COSINE = 0.87
MIN_HAND_PIXELS = 24
HAND_PROBE = 6
HAND_OVERLAP = 0.08


@dataclass(frozen=True, slots=True)
class Features:
    """Measurements of one view in px; lines point from the elbow outwards.

    `root` is the line from the forearm's middle near the elbow to the wrist. `forearm_sides` and `upper_arm_sides` are
    points (2, 2) on the skin just beside the elbow, against and along the normal of the limb's line, NaN where it is
    not seen. `wrist` is where the forearm becomes the palm, None where the silhouette does not show it; `hand` is the
    contour (M, 2) beyond it. `hand_shift` (2,) moves the hand's contour to the instant measured. `guess` are the rough
    positions that the measurement started from, updated by it.
    """

    forearm: MedialLine
    root: MedialLine
    forearm_sides: Array
    upper_arm: MedialLine | None
    upper_arm_sides: Array
    wrist: Array | None
    hand: Array | None
    half_width: float
    silhouette: Silhouette
    guess: Posture
    hand_shift: Array = field(default_factory=lambda: np.zeros(2))


def measure(silhouette: Silhouette, guess: Posture | None) -> Features | None:
    """The features of a silhouette near a guess, or else found without one; None if it shows no arm with a forearm."""
    near = _measure_near(silhouette, guess) if guess is not None else None
    if near is not None and near.upper_arm is not None:
        return near
    posture = find_posture(silhouette)
    if posture is None:
        return near
    if near is None:
        return _measure_near(silhouette, posture)
    ends = (posture.shoulder_end, posture.hand_end)
    nearer = min(ends, key=lambda end: float(np.sum((end - near.guess.elbow) ** 2)))
    return _measure_near(silhouette, replace(near.guess, shoulder_end=nearer)) or near


def _measure_near(silhouette: Silhouette, guess: Posture) -> Features | None:
    forearm = _forearm(silhouette, guess)
    if forearm is None:
        return None
    line, edges, length = forearm
    width = 0.5 * edges.widest(FOREARM_RANGE[0] * length, FOREARM_RANGE[1] * length)
    palm = palm_begin(*edges.rows, length, width)
    seen = not math.isnan(palm)
    wrist = line.at(palm if seen else length)
    guess = replace(guess, wrist=wrist)
    hand = _hand(silhouette, edges, (palm if seen else length) - HAND_OVERLAP * length)
    upper_arm, shoulder_end = _upper_arm(silhouette, guess)
    if upper_arm is not None and float(upper_arm.direction @ line.direction) > SAME_LIMB_COSINE:
        upper_arm, shoulder_end = None, line.at(-guess.half_width)  # beyond an elbow at the border: the forearm again
    guess = replace(guess, shoulder_end=shoulder_end)
    return Features(
        forearm=line,
        root=_root(edges, length, line.at(length), _crease(guess)) or line,
        forearm_sides=_sides(silhouette, line, guess, FOREARM_SIDES),
        upper_arm=upper_arm,
        upper_arm_sides=_sides(silhouette, upper_arm, guess, UPPER_ARM_SIDES),
        wrist=wrist if seen else None,
        hand=hand,
        half_width=width,
        silhouette=silhouette,
        guess=guess,
    )


def _root(edges: Edges, length: float, wrist: Array, crease: float) -> MedialLine | None:
    """The line from the forearm's middle near the elbow to the wrist.

    Muscle bends the medial axis; the bone's axis is straight, and the wrist lies on both.
    """
    low = max(ROOT_START * length, min(crease, 0.5 * length))
    rows, position, middle = mean_between(*edges.rows, low, low + ROOT_LENGTH * length)
    if rows < MIN_ROOT_ROWS:
        return None
    return line_through(edges.axis.at(position) + middle * edges.axis.normal, wrist)


def _sides(silhouette: Silhouette, limb: MedialLine | None, guess: Posture, half_widths: tuple[float, float]) -> Array:
    """The skin (2, 2) in px on both sides of a limb, between two distances in half widths from the elbow."""
    if limb is None:
        return np.full((2, 2), np.nan)
    near, far = (distance * guess.half_width for distance in half_widths)
    offsets = limb_sides(silhouette, limb, near, far, 2.2 * guess.half_width)
    result: Array = limb.at(0.5 * (near + far)) + offsets[:, None] * limb.normal
    return result


def _forearm(silhouette: Silhouette, guess: Posture) -> tuple[MedialLine, Edges, float] | None:
    """The forearm's medial line from the elbow's foot on it, its edges to beyond the wrist, and its length in px."""
    first = line_through(guess.elbow, guess.wrist)
    if first is None:
        return None
    axis, crease = first, _crease(guess)
    for _ in range(REFITS):
        length = axis.along(guess.wrist)
        edges = scan_edges(silhouette, axis, 0.0, length + 2 * guess.half_width, 2.2 * guess.half_width)
        low, high = max(FOREARM_RANGE[0] * length, min(crease, 0.6 * length)), FOREARM_RANGE[1] * length
        line = medial_line(edges, low, high)
        if line is None or line.direction @ first.direction < math.cos(MAX_TURN):
            return None
        axis = MedialLine(line.at(line.along(guess.elbow)), line.direction)
    length = axis.along(guess.wrist)
    edges = scan_edges(silhouette, axis, 0.0, length + 2 * guess.half_width, 2.2 * guess.half_width)
    seen = ~np.isnan(edges.lower[(edges.t >= low) & (edges.t <= high)])
    return (axis, edges, length) if len(seen) and float(seen.mean()) >= MIN_VALID else None


def _crease(guess: Posture) -> float:
    """The distance in px from the elbow to the crease, where forearm and upper arm separate; it grows with the bend."""
    (ex, ey), (wx, wy), (sx, sy) = guess.elbow.tolist(), guess.wrist.tolist(), guess.shoulder_end.tolist()
    product = math.hypot(wx - ex, wy - ey) * math.hypot(sx - ex, sy - ey)
    cosine = ((wx - ex) * (sx - ex) + (wy - ey) * (sy - ey)) / product if product > 0 else -1.0
    half_angle = 0.5 * math.acos(max(-1.0, min(cosine, MAX_CREASE_COSINE)))
    return guess.half_width / math.tan(half_angle) if half_angle < 0.5 * math.pi - 1e-6 else 0.0


def _hand(silhouette: Silhouette, edges: Edges, position: float) -> Array | None:
    """The contour (M, 2) beyond a position along the forearm's axis, in order."""
    clean = np.flatnonzero((edges.t <= position) & ~np.isnan(edges.lower))
    if not len(clean):
        return None
    last, normal = edges.axis.at(float(edges.t[clean[-1]])), edges.axis.normal
    ends = [(last + side[clean[-1]] * normal).tolist() for side in (edges.lower, edges.upper)]
    contour, (dx, dy) = silhouette.contour, edges.axis.direction
    low, high = sorted(int(np.argmin(np.sum((contour - end) ** 2, axis=1))) for end in ends)
    step = contour[min(low + HAND_PROBE, high)] - contour[low]
    inner = float(step[0] * dx + step[1] * dy) > 0
    part = contour[low : high + 1] if inner else np.concatenate([contour[high:], contour[: low + 1]])
    return part if len(part) >= MIN_HAND_PIXELS else None


def _upper_arm(silhouette: Silhouette, guess: Posture) -> tuple[MedialLine | None, Array]:
    """The upper arm's medial line, None if too little of it is seen, and the middle of its far end."""
    axis = line_through(guess.elbow, guess.shoulder_end)
    if axis is None:
        return None, guess.shoulder_end
    start = max(UPPER_ARM_START * guess.half_width, _crease(guess))
    length = axis.along(guess.shoulder_end) + guess.half_width
    begin, end = start, length
    for _ in range(REFITS + 1):
        edges = scan_edges(silhouette, axis, 0.0, length, 2.2 * guess.half_width)
        begin, end = limb_span(*edges.rows, start, guess.half_width)
        line = medial_line(edges, begin, end - 2)
        if line is None or end - begin < LEAST_UPPER_ARM * guess.half_width:
            return None, guess.shoulder_end
        axis = MedialLine(line.at(line.along(guess.elbow)), line.direction)
    return axis, axis.at(end)


NECK_WINDOW = 1.2
NECK_SMOOTHING = 5
PALM_GROWTH = 1.1
PALM_BEGINS = 0.06
WIDTH_CHANGE = 0.25
TYPICAL_HALF_WIDTHS = 1.5
SURE_PX = 3.0


@compiled
def mean_between(t: Array, lower: Array, upper: Array, start: float, end: float) -> tuple[int, float, float]:
    """Of the clean rows between two positions: their number, mean position and mean middle in px."""
    rows, position, middle = 0, 0.0, 0.0
    for k in range(len(t)):
        if start <= t[k] <= end and not math.isnan(lower[k]):
            rows, position = rows + 1, position + t[k]
            middle += 0.5 * (upper[k] + lower[k])
    return rows, position / max(rows, 1), middle / max(rows, 1)


@compiled
def palm_begin(t: Array, lower: Array, upper: Array, length: float, half_width: float) -> float:
    """The position of the wrist along the axis, from where the palm widens beyond the neck; NaN if it does not.

    The joint lies a small fraction of the forearm's length before that.
    """
    smooth = _smooth_width(lower, upper, 4 * half_width)
    first, last = -1, -1
    for k in range(len(t)):
        if abs(t[k] - length) < NECK_WINDOW * half_width:
            first, last = k if first < 0 else first, k
    if first < 0 or last - first + 1 < NECK_SMOOTHING:
        return math.nan
    neck = first + int(np.argmin(smooth[first : last + 1]))
    if neck == first:
        return math.nan
    limit = PALM_GROWTH * smooth[neck]
    for k in range(neck + 1, len(t)):
        if smooth[k] > limit:
            step = (limit - smooth[k - 1]) / (smooth[k] - smooth[k - 1])
            return float(t[k - 1] + step - PALM_BEGINS * length)
    return math.nan


@compiled
def _smooth_width(lower: Array, upper: Array, unseen: float) -> Array:
    """The widths (R,) averaged over neighbouring rows; rows without edges count as `unseen` px."""
    count, reach = len(lower), NECK_SMOOTHING // 2
    smooth = np.zeros(count)
    for k in range(count):
        for j in range(k - reach, k + reach + 1):
            width = upper[min(max(j, 0), count - 1)] - lower[min(max(j, 0), count - 1)]
            smooth[k] += (unseen if math.isnan(width) else width) / NECK_SMOOTHING
    return smooth


@compiled
def limb_span(t: Array, lower: Array, upper: Array, start: float, half_width: float) -> tuple[float, float]:
    """The first and last position along its axis, after `start`, between which the limb keeps its width.

    Near the crease, where it meets the other limb, rows are wider than the limb.
    """
    first = -1
    for k in range(len(t)):
        if t[k] > start and not math.isnan(lower[k]):
            first = k
            break
    if first < 0:
        return start, start
    typical = typical_width(t, lower, upper, t[first], t[first] + TYPICAL_HALF_WIDTHS * half_width)
    begin = -1
    for k in range(first, len(t)):
        kept = abs((upper[k] - lower[k]) / typical - 1) < WIDTH_CHANGE
        if kept and begin < 0:
            begin = k
        elif not kept and begin >= 0 and t[k] > t[begin] + SURE_PX:
            return float(t[begin]), float(t[k])
    return float(t[max(begin, first)]), float(t[-1])

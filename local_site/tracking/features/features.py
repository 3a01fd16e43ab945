"""The arm's features in one image: medial lines, wrist, hand, all in pixels."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from common.geometry import Array
from local_site.tracking.features.limb_width import limb_span, mean_between, palm_begin
from local_site.tracking.features.medial import Edges, MedialLine, limb_sides, line_through, medial_line, scan_edges
from local_site.tracking.features.posture import Posture, find_posture
from local_site.tracking.features.silhouette import Silhouette

FOREARM_RANGE = (0.3, 0.92)
ROOT_START, ROOT_LENGTH = 0.2, 0.2
MIN_ROOT_ROWS = 4
FOREARM_SIDES, UPPER_ARM_SIDES = (0.0, 0.6), (0.3, 1.0)
UPPER_ARM_START = 0.6
MAX_CREASE_COSINE = 0.87
REFITS = 1
MAX_TURN = math.radians(40.0)
MIN_VALID = 0.7
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

    @property
    def hand_cropped(self) -> bool:
        """Whether the image border cuts the hand."""
        return self.hand is not None and bool(self.silhouette.touches_border(self.hand).any())


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
    return (axis, edges, length) if edges.fraction_seen(low, high) >= MIN_VALID else None


def _crease(guess: Posture) -> float:
    """The distance in px from the elbow to the crease, where forearm and upper arm separate; it grows with the bend."""
    (ex, ey), (wx, wy), (sx, sy) = guess.elbow.tolist(), guess.wrist.tolist(), guess.shoulder_end.tolist()
    product = math.hypot(wx - ex, wy - ey) * math.hypot(sx - ex, sy - ey)
    cosine = ((wx - ex) * (sx - ex) + (wy - ey) * (sy - ey)) / product if product > 0 else -1.0
    half_angle = 0.5 * math.acos(max(-1.0, min(cosine, MAX_CREASE_COSINE)))
    return guess.half_width / math.tan(half_angle) if half_angle < 0.5 * math.pi - 1e-6 else 0.0


def _hand(silhouette: Silhouette, edges: Edges, position: float) -> Array | None:
    """The contour (M, 2) beyond a position along the forearm's axis, in order."""
    ends = edges.ends_before(position)
    if ends is None:
        return None
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
        if line is None:
            return None, guess.shoulder_end
        axis = MedialLine(line.at(line.along(guess.elbow)), line.direction)
    return axis, axis.at(end)

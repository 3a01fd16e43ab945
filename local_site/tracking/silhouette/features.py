"""What one camera frame says about the arm: medial lines, wrist, hand, all in pixels."""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.contour import Silhouette
from local_site.tracking.silhouette.medial import (
    Edges,
    Line,
    line_through,
    medial_line,
    middle_value,
    scan_edges,
    width_between,
)
from local_site.tracking.silhouette.posture import Posture, find_posture

FOREARM_RANGE = (0.3, 0.92)
ROOT_START, ROOT_LENGTH = 0.2, 0.2
MIN_ROOT_ROWS = 4
NEAR_SHARE = 0.4
UPPER_ARM_START = 0.6
WIDTH_CHANGE = 0.25
MAX_CREASE_COSINE = 0.87
REFITS = 1
MAX_TURN = math.radians(40.0)
MIN_VALID = 0.7
NECK_WINDOW = 1.2
NECK_SMOOTHING = 5
PALM_GROWTH = 1.1
PALM_BEGINS = 0.06
MIN_HAND_PIXELS = 24
HAND_PROBE = 6
HAND_OVERLAP = 0.08


@dataclass(frozen=True, slots=True)
class Features:
    """Measurements of one view in px; lines point from the elbow outwards.

    `root` leads from the forearm's middle near the elbow, at `root_share` of its length, to the wrist. `wrist` is where
    the forearm turns into the palm, None where the silhouette does not show it; `hand` is the contour (M, 2) beyond it.
    Widths are those of the limbs near the elbow. `hand_shift` (2,) takes what was seen of the hand to the instant
    measured. `guess` are the rough positions that the measurement started from, brought up to date.
    """

    forearm: Line
    root: Line
    root_width: float
    root_share: float
    upper_arm: Line | None
    upper_arm_width: float
    wrist: Array | None
    hand: Array | None
    half_width: float
    silhouette: Silhouette
    guess: Posture
    hand_cropped: bool
    shoulder_cropped: bool
    hand_shift: Array = field(default_factory=lambda: np.zeros(2))


def measure(silhouette: Silhouette, guess: Posture | None) -> Features | None:
    """The features of a silhouette near a guess, or found afresh; None where it shows no arm with a forearm."""
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
    width = 0.5 * float(np.nanmax(edges.width[(edges.t > 0.3 * length) & (edges.t < length)]))
    palm = _palm(edges, length, width)
    wrist = line.at(palm if palm is not None else length)
    guess = replace(guess, wrist=wrist)
    hand = _hand(silhouette, edges, (palm if palm is not None else length) - HAND_OVERLAP * length)
    upper_arm, upper_width, shoulder_end = _upper_arm(silhouette, guess)
    guess = replace(guess, shoulder_end=shoulder_end)
    far = line.at(length)
    root, root_width, root_share = _root(edges, length, far, _crease(guess)) or (line, 2 * width, 0.0)
    return Features(
        forearm=line,
        root=root,
        root_width=root_width,
        root_share=root_share,
        upper_arm=upper_arm,
        upper_arm_width=upper_width,
        wrist=wrist if palm is not None else None,
        hand=hand,
        half_width=width,
        silhouette=silhouette,
        guess=guess,
        hand_cropped=hand is not None and bool(silhouette.touches_border(hand).any()),
        shoulder_cropped=silhouette.at_border,
    )


def _root(edges: Edges, length: float, wrist: Array, crease: float) -> tuple[Line, float, float] | None:
    """The line from the forearm's middle near the elbow to the wrist, the width there, and its share of the length.

    Muscle bends the medial axis; the bone's axis is straight, and the wrist lies on both.
    """
    low = max(ROOT_START * length, min(crease, 0.5 * length))
    chosen = (edges.t >= low) & (edges.t <= low + ROOT_LENGTH * length) & np.isfinite(edges.lower)
    if np.count_nonzero(chosen) < MIN_ROOT_ROWS:
        return None
    place, middle = float(edges.t[chosen].mean()), 0.5 * float((edges.upper + edges.lower)[chosen].mean())
    line = line_through(edges.axis.at(place) + middle * edges.axis.normal, wrist)
    return None if line is None else (line, float(edges.width[chosen].mean()), place / max(length, 1.0))


def _forearm(silhouette: Silhouette, guess: Posture) -> tuple[Line, Edges, float] | None:
    """The forearm's medial line from the elbow's foot, its edges beyond the wrist, and elbow to wrist in px."""
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
        axis = Line(line.at(line.along(guess.elbow)), line.direction)
    length = axis.along(guess.wrist)
    edges = scan_edges(silhouette, axis, 0.0, length + 2 * guess.half_width, 2.2 * guess.half_width)
    inside = (edges.t >= low) & (edges.t <= high)
    if np.isfinite(edges.width[inside]).mean() < MIN_VALID:
        return None
    return axis, edges, length


def _crease(guess: Posture) -> float:
    """How far from the elbow, in px, forearm and upper arm part: the sharper the bend, the farther."""
    to_wrist, to_shoulder = guess.wrist - guess.elbow, guess.shoulder_end - guess.elbow
    product = math.sqrt(float(to_wrist @ to_wrist) * float(to_shoulder @ to_shoulder))
    cosine = float(to_wrist @ to_shoulder) / product if product > 0 else -1.0
    half_angle = 0.5 * math.acos(max(-1.0, min(cosine, MAX_CREASE_COSINE)))
    return guess.half_width / math.tan(half_angle) if half_angle < 0.5 * math.pi - 1e-6 else 0.0


def _palm(edges: Edges, length: float, half_width: float) -> float | None:
    """Where along the axis the wrist is, told by where the palm begins to widen beyond the narrowest place.

    The joint lies a small share of the forearm's length before that; None where nothing widens.
    """
    width = np.where(np.isfinite(edges.width), edges.width, 4 * half_width)
    kernel = np.full(NECK_SMOOTHING, 1 / NECK_SMOOTHING)
    smooth = np.convolve(np.pad(width, NECK_SMOOTHING // 2, mode="edge"), kernel, mode="valid")
    window = np.flatnonzero(np.abs(edges.t - length) < NECK_WINDOW * half_width)
    if len(window) < NECK_SMOOTHING:
        return None
    k = int(window[np.argmin(smooth[window])])
    wider = np.flatnonzero(smooth[k:] > PALM_GROWTH * smooth[k])
    if k == window[0] or not len(wider):
        return None
    after = k + int(wider[0])
    step = (PALM_GROWTH * smooth[k] - smooth[after - 1]) / (smooth[after] - smooth[after - 1])
    return float(edges.t[after - 1]) + float(step) - PALM_BEGINS * length


def _hand(silhouette: Silhouette, edges: Edges, place: float) -> Array | None:
    """The contour (M, 2) beyond a place along the forearm's axis, in order."""
    usable = np.flatnonzero(np.isfinite(edges.width) & (edges.t <= place))
    if not len(usable):
        return None
    k = usable[-1]
    middle, normal = edges.axis.at(float(edges.t[k])), edges.axis.normal
    contour = silhouette.contour
    ends = (middle + edges.lower[k] * normal, middle + edges.upper[k] * normal)
    low, high = sorted(int(np.argmin(np.sum((contour - end) ** 2, axis=1))) for end in ends)
    beyond = min(low + HAND_PROBE, high)
    inner = float(edges.axis.direction @ (contour[beyond] - contour[low])) > 0
    part = contour[low : high + 1] if inner else np.concatenate([contour[high:], contour[: low + 1]])
    return part if len(part) >= MIN_HAND_PIXELS else None


def _upper_arm(silhouette: Silhouette, guess: Posture) -> tuple[Line | None, float, Array]:
    """The upper arm's medial line, None where too little of it shows, its width, and the middle of its far end."""
    axis = line_through(guess.elbow, guess.shoulder_end)
    if axis is None:
        return None, 0.0, guess.shoulder_end
    start = max(UPPER_ARM_START * guess.half_width, _crease(guess))
    length = axis.along(guess.shoulder_end) + guess.half_width
    end = length
    for _ in range(REFITS + 1):
        edges = scan_edges(silhouette, axis, 0.0, length, 2.2 * guess.half_width)
        end = _limb_end(edges, start, guess.half_width)
        line = medial_line(edges, start, end - 2)
        if line is None:
            return None, 0.0, guess.shoulder_end
        axis = Line(line.at(line.along(guess.elbow)), line.direction)
    width = width_between(edges, start, start + NEAR_SHARE * (end - start))
    return axis, 2 * guess.half_width if width is None else width, axis.at(end)


def _limb_end(edges: Edges, start: float, half_width: float) -> float:
    """How far along its axis the limb keeps its width, from where it first shows two edges."""
    shown = np.flatnonzero((edges.t > start) & np.isfinite(edges.width))
    if not len(shown):
        return start
    first = float(edges.t[shown[0]])
    typical = middle_value(edges.width[shown[edges.t[shown] < first + 1.5 * half_width]])
    with np.errstate(invalid="ignore"):
        kept = np.abs(edges.width / typical - 1) < WIDTH_CHANGE
    broken = np.flatnonzero((edges.t > first + 3) & ~kept)
    return float(edges.t[broken[0]] if len(broken) else edges.t[-1])

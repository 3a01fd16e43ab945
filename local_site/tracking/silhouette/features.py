"""What one camera frame says about the arm: medial lines, wrist, hand, all in pixels."""

import math
from dataclasses import dataclass, replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.contour import Silhouette
from local_site.tracking.silhouette.hand import Hand, hand_contour, measure_hand
from local_site.tracking.silhouette.medial import Edges, Line, line_through, medial_line, middle_value, scan_edges
from local_site.tracking.silhouette.posture import Posture, find_posture

FOREARM_RANGE = (0.3, 0.92)
UPPER_ARM_START = 0.6
WIDTH_CHANGE = 0.25
MAX_CREASE_COSINE = 0.87
REFITS = 2
MAX_TURN = math.radians(40.0)
MIN_VALID = 0.7
NECK_WINDOW = 1.2
NECK_SMOOTHING = 5
MIN_NECK = 0.02


@dataclass(frozen=True, slots=True)
class Features:
    """Measurements of one view in px; lines point from the elbow outwards.

    `wrist` is the neck between forearm and palm, None where the silhouette shows none. `guess` are the rough positions
    that the measurement started from, brought up to date.
    """

    forearm: Line
    upper_arm: Line | None
    wrist: Array | None
    hand: Hand | None
    half_width: float
    silhouette: Silhouette
    guess: Posture
    hand_cropped: bool
    shoulder_cropped: bool


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
    return _measure_near(silhouette, replace(near.guess, shoulder_end=posture.shoulder_end)) or near


def _measure_near(silhouette: Silhouette, guess: Posture) -> Features | None:
    forearm = _forearm(silhouette, guess)
    if forearm is None:
        return None
    line, edges, length = forearm
    width = 0.5 * float(np.nanmax(edges.width[(edges.t > 0.3 * length) & (edges.t < length)]))
    neck = _neck(edges, length, width)
    wrist = line.at(neck if neck is not None else length)
    guess = replace(guess, wrist=wrist)
    hand = _hand(silhouette, edges, neck if neck is not None else length, guess, width)
    upper_arm, shoulder_end = _upper_arm(silhouette, guess)
    guess = replace(guess, shoulder_end=shoulder_end)
    measured = wrist if neck is not None else None
    cropped = hand is not None and bool(silhouette.touches_border(hand.contour).any())
    return Features(line, upper_arm, measured, hand, width, silhouette, guess, cropped, silhouette.at_border)


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


def _neck(edges: Edges, length: float, half_width: float) -> float | None:
    """Where along the axis the forearm is narrowest before the palm, to a fraction of a px; None without a neck."""
    width = np.where(np.isfinite(edges.width), edges.width, 4 * half_width)
    kernel = np.full(NECK_SMOOTHING, 1 / NECK_SMOOTHING)
    smooth = np.convolve(np.pad(width, NECK_SMOOTHING // 2, mode="edge"), kernel, mode="valid")
    window = np.flatnonzero(np.abs(edges.t - length) < NECK_WINDOW * half_width)
    if len(window) < NECK_SMOOTHING:
        return None
    k = int(window[np.argmin(smooth[window])])
    beyond = smooth[k : window[-1] + 1].max() - smooth[k]
    if k in (window[0], window[-1]) or beyond < MIN_NECK * half_width:
        return None
    a, b, c = smooth[k - 1], smooth[k], smooth[k + 1]
    curvature = a - 2 * b + c
    return float(edges.t[k]) + (0.5 * float((a - c) / curvature) if curvature > 1e-9 else 0.0)


def _hand(silhouette: Silhouette, edges: Edges, place: float, guess: Posture, half_width: float) -> Hand | None:
    usable = np.flatnonzero(np.isfinite(edges.width) & (edges.t <= place))
    if not len(usable):
        return None
    k = usable[-1]
    middle, normal = edges.axis.at(float(edges.t[k])), edges.axis.normal
    sides = (middle + edges.lower[k] * normal, middle + edges.upper[k] * normal)
    contour = hand_contour(silhouette.contour, sides, guess.shoulder_end)
    return measure_hand(contour, guess.wrist, half_width) if contour is not None else None


def _upper_arm(silhouette: Silhouette, guess: Posture) -> tuple[Line | None, Array]:
    """The upper arm's medial line, None where too little of it shows, and the middle of its far end."""
    axis = line_through(guess.elbow, guess.shoulder_end)
    if axis is None:
        return None, guess.shoulder_end
    start = max(UPPER_ARM_START * guess.half_width, _crease(guess))
    length = axis.along(guess.shoulder_end) + guess.half_width
    end = length
    for _ in range(REFITS + 1):
        edges = scan_edges(silhouette, axis, 0.0, length, 2.2 * guess.half_width)
        end = _limb_end(edges, start, guess.half_width)
        line = medial_line(edges, start, end - 2)
        if line is None:
            return None, guess.shoulder_end
        axis = Line(line.at(line.along(guess.elbow)), line.direction)
    return axis, axis.at(end)


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

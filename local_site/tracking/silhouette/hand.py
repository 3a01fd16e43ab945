"""Finger tips: prominent maxima along the hand's contour, seen across cutting lines (thesis 3.1.10, 4.2)."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import find_peaks, peak_prominences

from common.geometry import Array

CUTTING_ANGLE = math.radians(61.0)
MIN_PROMINENCE = 0.03
OPEN_PROMINENCE = 0.08
OPEN_TIPS = 4
SAME_TIP = 0.14
TIE_BREAK = 1e-6
MIN_HAND_POINTS = 12
CORNER_REACH = 0.2
MIN_TURN = math.radians(30.0)
_OUTWARD = -1.0  # OpenCV walks outer contours so that the shape lies to the left in an image with y down


@dataclass(frozen=True, slots=True)
class Tip:
    """A finger-like end of the hand: its pixel (2,), its prominence relative to the hand's length, and the angle in rad
    between its sides, by which a bent knuckle is told from a finger tip."""

    point: Array
    prominence: float
    angle: float = 0.0


@dataclass(frozen=True, slots=True)
class Hand:
    """The hand in one view: contour (M, 2) from one side of the wrist to the other, and its length from the wrist, px.

    `tips` stand out and are in order along the contour; `corners` (C, 2) are all places where it turns sharply outwards
    as around a finger tip, also tips that hardly stand out from their neighbours. `farthest` (2,) is the contour's
    point farthest from the wrist, `open_tips` the number of tips that stand clear of each other as seen from the wrist.
    """

    contour: Array
    tips: tuple[Tip, ...]
    corners: Array
    farthest: Array
    length: float
    open_tips: int

    @property
    def spread(self) -> bool:
        """Whether so many fingers stand apart that the hand is open; curled fingers show up to three tips."""
        return self.open_tips >= OPEN_TIPS


def hand_contour(contour: Array, sides: tuple[Array, Array], shoulder_end: Array) -> Array | None:
    """The part of a closed contour (N, 2) beyond two points (2,) at the sides of the wrist, away from the shoulder."""
    first, second, shoulder = (_nearest(contour, point) for point in (*sides, shoulder_end))
    low, high = min(first, second), max(first, second)
    inner = low <= shoulder <= high
    part = np.concatenate([contour[high:], contour[: low + 1]]) if inner else contour[low : high + 1]
    return part if len(part) >= MIN_HAND_POINTS else None


def measure_hand(contour: Array, wrist: Array, half_width: float) -> Hand:
    """Tips of a hand contour (M, 2) about the wrist (2,); `half_width` is the forearm's in px.

    A cutting line that moves along its normal n towards the fingers splits the hand where s(i) = n (p_i - w) has
    separate superlevel sets, so its blobs are the prominent maxima of s along the contour.
    """
    arms = contour - wrist
    distance = np.hypot(arms[:, 0], arms[:, 1])
    end = int(np.argmax(distance))
    length = float(distance[end])
    sigma = arms[end] / max(length, 1.0)
    heights = [arms @ _turned(sigma, turn) for turn in (math.pi / 2 - CUTTING_ANGLE, CUTTING_ANGLE - math.pi / 2)]
    found = [_peaks(height, length) for height in (*heights, distance)]
    open_tips = sum(prominence >= OPEN_PROMINENCE for _, prominence in found[-1])
    corners = find_corners(contour, CORNER_REACH * half_width)
    tips = _merged(contour, distance, found, length, half_width)
    return Hand(contour, tips, corners, contour[end], length, open_tips)


def find_corners(contour: Array, reach: float) -> Array:
    """Where an open contour (M, 2) turns outwards by MIN_TURN within ± reach px, (C, 2)."""
    k = max(2, round(reach))
    if len(contour) < 4 * k:
        return np.empty((0, 2))
    smooth = np.column_stack([np.convolve(contour[:, d], np.full(3, 1 / 3), mode="valid") for d in (0, 1)])
    before, after = smooth[k:-k] - smooth[: -2 * k], smooth[2 * k :] - smooth[k:-k]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.arctan2(cross, np.sum(before * after, axis=1))
    peaks = find_peaks(_OUTWARD * turn, height=MIN_TURN, distance=k)[0]
    return contour[peaks + k + 1]


def _nearest(contour: Array, point: Array) -> int:
    return int(np.argmin(np.sum((contour - point) ** 2, axis=1)))


def _turned(vector: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def _peaks(height: Array, length: float) -> list[tuple[int, float]]:
    """Contour index and relative prominence of the prominent maxima of a height along the contour."""
    smooth = np.convolve(height, np.full(3, 1 / 3), mode="same")
    smooth[[0, -1]] = height[[0, -1]]
    smooth += TIE_BREAK * np.arange(len(smooth))  # of two equal maxima only one shall have the whole prominence
    candidates = find_peaks(smooth)[0]
    prominence = peak_prominences(smooth, candidates)[0] / max(length, 1.0)
    kept = prominence >= MIN_PROMINENCE
    return [(int(i), float(p)) for i, p in zip(candidates[kept], prominence[kept], strict=True)]


def _merged(
    contour: Array, distance: Array, found: list[list[tuple[int, float]]], length: float, reach: float
) -> tuple[Tip, ...]:
    """One tip for maxima of different directions on the same finger: their most distant point from the wrist."""
    everything = sorted(peak for peaks in found for peak in peaks)
    groups: list[list[tuple[int, float]]] = []
    for index, prominence in everything:
        near = groups and np.hypot(*(contour[index] - contour[groups[-1][-1][0]])) < SAME_TIP * length
        if near:
            groups[-1].append((index, prominence))
        else:
            groups.append([(index, prominence)])
    tips = []
    for group in groups:
        best = max(group, key=lambda peak: distance[peak[0]])[0]
        tips.append(Tip(contour[best], max(p for _, p in group), _angle(contour, best, reach)))
    return tuple(tips)


def _angle(contour: Array, index: int, reach: float) -> float:
    """The angle in rad between the contour's two sides at a point, each followed for `reach` px."""
    step = np.hypot(*np.diff(contour, axis=0).T)
    arc = np.concatenate([[0.0], np.cumsum(step)])
    ends = np.searchsorted(arc, [arc[index] - reach, arc[index] + reach])
    a, b = (contour[min(int(k), len(contour) - 1)] - contour[index] for k in ends)
    product = math.sqrt(float(a @ a) * float(b @ b))
    return math.acos(max(-1.0, min(1.0, float(a @ b) / product))) if product > 0 else math.pi

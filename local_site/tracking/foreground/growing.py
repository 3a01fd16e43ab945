"""The arm's region in a map of log ratios: what is connected to the hand, where an arm can be."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.kernels.compiled import compiled
from local_site.tracking.foreground.likelihood import LogRatios
from local_site.tracking.foreground.room import Mask, Place
from local_site.tracking.foreground.tubes import LEAST_DEPTH_M, ArmTubes, RatioMap, Tube, homogeneous
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_KNUCKLE, WRIST

FINGERS = ((0, 1, 2, 3, 4), (0, 5, 6, 7, 8), (0, 9, 10, 11, 12), (0, 13, 14, 15, 16), (0, 17, 18, 19, 20))
PALM = (0, 1, 5, 9, 13, 17)
_CHAINS = np.array(FINGERS)
BARE = 2  # joint of a finger's chain, from which on no cuff covers it
KNUCKLES, HEEL = (2, 5, 9, 13, 17), 0.4  # the palm begins so far on the way from the wrist to the middle knuckle
FINGER_M, FLESH_M = 0.016, 0.024  # skin is at most so far from the bones of fingers and palm, as they are found
WIDER = 1.6  # than the tube: an arm that bulges, a tube a little beside it
ELBOW_M, UPPER_ARM_M = 0.13, 0.075  # the elbow is only known roughly
NEVER, PERHAPS, LIKELY, SURE = 0, 1, 2, 3
CORE, CLEARLY = 0.5, 1.0  # the tube's middle, and the log ratio that is the arm's there, whatever lies between
BAND_M = 0.04  # the widest watch or band around the wrist
LEAST_PERHAPS, LEAST_LIKELY = 0.4, -0.4  # the log ratio that continues the region


def grow(view: RatioMap, possible: Mask, tubes: ArmTubes) -> Mask:
    """The arm's squares (h, w), 1 where it is: connected to the hand, or beyond a band around the wrist."""
    smooth = np.asarray(cv2.GaussianBlur(view.ratios, (3, 3), 0), dtype=np.float32)
    seeds = possible.copy()
    seeds[(within(view, tubes.forearm, CORE) > 0) & (smooth > CLEARLY)] = SURE
    arm, parts = _connected(smooth, seeds)
    if parts > 1 and cv2.connectedComponents(arm)[0] > 2:
        arm = _bridged(arm, view, tubes)
    return _filled(arm)


def within(view: RatioMap, tube: Tube, wider: float) -> Mask:
    """The squares (h, w) of a tube, that many times as wide."""
    drawn = np.zeros(view.ratios.shape, np.uint8)
    draw_tube(drawn, view, tube, 1, wider)
    return drawn


def _bridged(arm: Mask, view: RatioMap, tubes: ArmTubes) -> Mask:
    """The arm's parts joined over a watch or a band on the forearm; without what is still apart from the hand."""
    reach = round(BAND_M * view.squares_per_m(tubes.forearm.start)) | 1
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    closed = np.asarray(cv2.morphologyEx(arm, cv2.MORPH_CLOSE, kernel), np.uint8)
    joined = np.asarray(cv2.max(arm, closed * within(view, tubes.forearm, 1.0)), np.uint8)
    labels = cv2.connectedComponents(joined)[1]
    x, y = _point(view.to_squares(project(view.projection, tubes.forearm.start)))
    rows, columns = arm.shape
    wrist = labels[min(max(y, 0), rows - 1), min(max(x, 0), columns - 1)]
    return np.asarray((labels == wrist) & (joined > 0), np.uint8) if wrist else joined


def bones(view: RatioMap, hand: Array) -> Mask:
    """The squares (h, w) surely on the hand's skin: its bones and the palm, but for the wrist, where a cuff may be."""
    drawn = np.zeros(view.ratios.shape, np.uint8)
    positions = view.to_squares(hand)
    squares = np.rint(positions).astype(np.int32)
    cv2.polylines(drawn, list(squares[_CHAINS[:, BARE:]]), False, 1)
    heel = positions[WRIST] + HEEL * (positions[MIDDLE_KNUCKLE] - positions[WRIST])
    corners = np.vstack([squares[list(KNUCKLES)], np.rint(heel).astype(np.int32)])
    cv2.fillConvexPoly(drawn, cv2.convexHull(corners), 1)
    return drawn


def draw_tube(drawn: Mask, view: RatioMap, tube: Tube, value: int, wider: float) -> None:
    """Draw a tube into squares (h, w), that many times as wide."""
    start, end = tube.half_widths
    half_widths_px = wider * start * view.focal_px, wider * end * view.focal_px
    _fill(drawn, view.projection, view.place, (tube.start, tube.end), half_widths_px, value)


def _draw_around(drawn: Mask, view: RatioMap, ends: tuple[Array, Array], radius_m: float, value: int) -> None:
    """Draw what lies within a radius of a line between two points (3,) in m into squares (h, w)."""
    _fill(drawn, view.projection, view.place, ends, (radius_m * view.focal_px, radius_m * view.focal_px), value)


@compiled
def _fill(
    drawn: Mask,
    projection: Array,
    place: Place,
    ends: tuple[Array, Array],
    half_widths_px: tuple[float, float],
    value: int,
) -> None:
    """Fill what lies within half widths, those at depth 1, of the line between two points (3,) in m."""
    left, top, stride = place
    ax, ay, depth = homogeneous(projection, ends[0])
    bx, by, end_depth = homogeneous(projection, ends[1])
    depth, end_depth = max(depth, LEAST_DEPTH_M), max(end_depth, LEAST_DEPTH_M)
    ax, ay = (ax / depth - left + 0.5) / stride - 0.5, (ay / depth - top + 0.5) / stride - 0.5
    bx, by = (bx / end_depth - left + 0.5) / stride - 0.5, (by / end_depth - top + 0.5) / stride - 0.5
    # Half a square more: what a tube only touches may be the arm, too.
    start_radius = half_widths_px[0] / (stride * depth) + 0.5
    end_radius = half_widths_px[1] / (stride * end_depth) + 0.5
    dx, dy = bx - ax, by - ay
    square, most = max(dx * dx + dy * dy, 1e-9), max(start_radius, end_radius)
    rows, columns = drawn.shape
    for j in range(max(int(min(ay, by) - most), 0), min(int(max(ay, by) + most) + 2, rows)):
        for i in range(max(int(min(ax, bx) - most), 0), min(int(max(ax, bx) + most) + 2, columns)):
            along = min(max(((i - ax) * dx + (j - ay) * dy) / square, 0.0), 1.0)
            radius = start_radius + along * (end_radius - start_radius)
            x, y = i - ax - along * dx, j - ay - along * dy
            if x * x + y * y <= radius * radius:
                drawn[j, i] = value


def _point(position: Array) -> tuple[int, int]:
    x, y = np.rint(position).astype(int).tolist()
    return x, y


def near_bones(view: RatioMap, hand: Array, wrist: Array) -> Mask:
    """The squares (h, w) that can be on a hand with landmarks at pixels (21, 2) and a wrist (3,) in m, as PERHAPS."""
    drawn = np.zeros(view.ratios.shape, np.uint8)
    squares = np.rint(view.to_squares(hand)).astype(np.int32)
    finger, palm = (max(round(2 * flesh * view.squares_per_m(wrist)), 1) for flesh in (FINGER_M, FLESH_M))
    cv2.polylines(drawn, list(squares[_CHAINS]), False, PERHAPS, finger)
    cv2.polylines(drawn, [squares[list(PALM)]], True, PERHAPS, palm)
    cv2.fillConvexPoly(drawn, cv2.convexHull(squares[list(PALM)]), PERHAPS)
    return drawn


def zones(view: RatioMap, on_bones: Mask, near_hand: Mask, tubes: ArmTubes) -> Mask:
    """Where the arm can be (h, w), from NEVER to SURE, by where the hand's bones are and what is near them."""
    drawn = near_hand.copy()
    elbow = tubes.forearm.end
    _draw_around(drawn, view, (elbow, elbow), ELBOW_M, PERHAPS)
    _draw_around(drawn, view, (elbow, tubes.upper_arm.end), UPPER_ARM_M, PERHAPS)
    draw_tube(drawn, view, tubes.forearm, PERHAPS, WIDER)
    draw_tube(drawn, view, tubes.forearm, LIKELY, 0.8)
    return np.asarray(cv2.max(drawn, on_bones * np.uint8(SURE)), np.uint8)


def disc(view: RatioMap, middle: Array, radius_m: float) -> Mask:
    """The squares (h, w) within a radius of a point (3,) in m, 1 where they are."""
    drawn = np.zeros(view.ratios.shape, np.uint8)
    _draw_around(drawn, view, (middle, middle), radius_m, 1)
    return drawn


@compiled
def _connected(ratios: LogRatios, possible: Mask) -> tuple[Mask, int]:
    """The squares (h, w) that are connected to those that are SURE, and how many parts they have."""
    rows, columns = possible.shape
    arm, queue = np.zeros((rows, columns), np.uint8), np.empty((rows * columns, 2), np.int32)
    parts = 0
    for y in range(rows):
        for x in range(columns):
            if possible[y, x] != SURE or arm[y, x]:
                continue
            parts, first, count = parts + 1, 0, 1
            arm[y, x], queue[0, 0], queue[0, 1] = 1, x, y
            while first < count:
                i, j = queue[first]
                first += 1
                for di, dj in ((1, 0), (-1, 0), (0, 1), (0, -1)):
                    u, v = i + di, j + dj
                    if (
                        0 <= u < columns
                        and 0 <= v < rows
                        and not arm[v, u]
                        and _continues(possible[v, u], ratios[v, u])
                    ):
                        arm[v, u], queue[count, 0], queue[count, 1] = 1, u, v
                        count += 1
    return arm, parts


@compiled
def _continues(zone: int, ratio: float) -> bool:
    """Whether the arm's region goes on in a square of a zone."""
    return bool(
        zone == SURE or (zone == LIKELY and ratio > LEAST_LIKELY) or (zone == PERHAPS and ratio > LEAST_PERHAPS)
    )


def _filled(region: Mask) -> Mask:
    """The region without holes and threads."""
    contours: Sequence[NDArray[np.int32]] = cv2.findContours(region, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]  # type: ignore[assignment]
    filled = np.zeros_like(region)
    cv2.drawContours(filled, contours, -1, 1, cv2.FILLED)
    return filled

"""The arm's region in a map of log ratios: what is connected to the hand, where an arm can be."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from common.geometry import Array
from local_site.calibration.triangulation import project
from local_site.tracking.foreground.likelihood import LogRatios
from local_site.tracking.foreground.room import Mask
from local_site.tracking.foreground.tubes import ArmTubes, RatioMap, Tube
from local_site.tracking.landmarks.hand_landmarks import MIDDLE_KNUCKLE, WRIST

FINGERS = ((0, 1, 2, 3, 4), (0, 5, 6, 7, 8), (0, 9, 10, 11, 12), (0, 13, 14, 15, 16), (0, 17, 18, 19, 20))
PALM = (0, 1, 5, 9, 13, 17)
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
    arm = _connected(smooth, seeds)
    if cv2.connectedComponents(arm)[0] > 2:
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
    cv2.polylines(drawn, [squares[list(finger[BARE:])] for finger in FINGERS], False, 1)
    heel = positions[WRIST] + HEEL * (positions[MIDDLE_KNUCKLE] - positions[WRIST])
    corners = np.vstack([squares[list(KNUCKLES)], np.rint(heel).astype(np.int32)])
    cv2.fillConvexPoly(drawn, cv2.convexHull(corners), 1)
    return drawn


def draw_tube(drawn: Mask, view: RatioMap, tube: Tube, value: int, wider: float) -> None:
    """Draw a tube into squares (h, w)."""
    ends = np.array([tube.start, tube.end])
    middles = view.to_squares(project(view.projection, ends))
    along = middles[1] - middles[0]
    normal = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-6)
    half = [wider * width * view.squares_per_m(end) for width, end in zip(tube.half_widths, ends, strict=True)]
    corners = [
        middles[0] + half[0] * normal,
        middles[1] + half[1] * normal,
        middles[1] - half[1] * normal,
        middles[0] - half[0] * normal,
    ]
    cv2.fillConvexPoly(drawn, np.rint(corners).astype(np.int32), value)
    for middle, radius in zip(middles, half, strict=True):
        cv2.circle(drawn, _point(middle), round(radius), value, cv2.FILLED)


def _point(position: Array) -> tuple[int, int]:
    x, y = np.rint(position).astype(int).tolist()
    return x, y


def near_bones(view: RatioMap, hand: Array, wrist: Array) -> Mask:
    """The squares (h, w) that can be on a hand with landmarks at pixels (21, 2) and a wrist (3,) in m, as PERHAPS."""
    drawn = np.zeros(view.ratios.shape, np.uint8)
    squares = np.rint(view.to_squares(hand)).astype(np.int32)
    finger, palm = (max(round(2 * flesh * view.squares_per_m(wrist)), 1) for flesh in (FINGER_M, FLESH_M))
    cv2.polylines(drawn, [squares[list(bones)] for bones in FINGERS], False, PERHAPS, finger)
    cv2.polylines(drawn, [squares[list(PALM)]], True, PERHAPS, palm)
    cv2.fillConvexPoly(drawn, cv2.convexHull(squares[list(PALM)]), PERHAPS)
    return drawn


def zones(view: RatioMap, on_bones: Mask, near_hand: Mask, tubes: ArmTubes) -> Mask:
    """Where the arm can be (h, w), from NEVER to SURE, by where the hand's bones are and what is near them."""
    drawn = near_hand.copy()
    scale = view.squares_per_m(tubes.forearm.end)
    middles = view.to_squares(project(view.projection, np.array([tubes.forearm.end, tubes.upper_arm.end])))
    cv2.circle(drawn, _point(middles[0]), round(ELBOW_M * scale), PERHAPS, cv2.FILLED)
    cv2.line(drawn, _point(middles[0]), _point(middles[1]), PERHAPS, max(round(2 * UPPER_ARM_M * scale), 1))
    draw_tube(drawn, view, tubes.forearm, PERHAPS, WIDER)
    draw_tube(drawn, view, tubes.forearm, LIKELY, 0.8)
    drawn[on_bones > 0] = SURE
    return drawn


def _connected(ratios: LogRatios, possible: Mask) -> Mask:
    """The squares (h, w) that are connected to those that are SURE."""
    sure = possible == SURE
    likely = (possible == LIKELY) & (ratios > LEAST_LIKELY)
    allowed = sure | likely | ((possible == PERHAPS) & (ratios > LEAST_PERHAPS))
    count, labels = cv2.connectedComponents(allowed.astype(np.uint8), connectivity=4)
    kept = np.zeros(count, np.uint8)
    kept[labels[sure]] = 1
    return np.asarray(kept[labels], np.uint8)


def _filled(region: Mask) -> Mask:
    """The region without holes and threads."""
    contours: Sequence[NDArray[np.int32]] = cv2.findContours(region, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]  # type: ignore[assignment]
    filled = np.zeros_like(region)
    cv2.drawContours(filled, contours, -1, 1, cv2.FILLED)
    return filled

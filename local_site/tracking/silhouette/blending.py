"""Features at an instant between two exposures of one camera, for cameras that do not expose together."""

from dataclasses import replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.hand import Hand
from local_site.tracking.silhouette.medial import Line
from local_site.tracking.silhouette.posture import Posture

SAME_TIP = 0.3


def blend(before: Features, now: Features, weight: float) -> Features:
    """The features at a fraction `weight` of the way from one frame of a camera to its next."""
    return replace(
        now,
        forearm=_line(before.forearm, now.forearm, weight),
        upper_arm=_upper_arm(before.upper_arm, now.upper_arm, weight),
        wrist=None if before.wrist is None or now.wrist is None else _mix(before.wrist, now.wrist, weight),
        hand=_hands(before.hand, now.hand, weight),
        guess=_posture(before.guess, now.guess, weight),
    )


def _mix(before: Array, now: Array, weight: float) -> Array:
    result: Array = (1 - weight) * before + weight * now
    return result


def _line(before: Line, now: Line, weight: float) -> Line:
    direction = _mix(before.direction, now.direction, weight)
    return Line(_mix(before.point, now.point, weight), direction / max(float(np.linalg.norm(direction)), 1e-9))


def _upper_arm(before: Line | None, now: Line | None, weight: float) -> Line | None:
    return None if before is None or now is None else _line(before, now, weight)


def _posture(before: Posture, now: Posture, weight: float) -> Posture:
    return Posture(
        shoulder_end=_mix(before.shoulder_end, now.shoulder_end, weight),
        elbow=_mix(before.elbow, now.elbow, weight),
        wrist=_mix(before.wrist, now.wrist, weight),
        hand_end=_mix(before.hand_end, now.hand_end, weight),
        half_width=now.half_width,
    )


def _hands(before: Hand | None, now: Hand | None, weight: float) -> Hand | None:
    """The tips that both frames show, moved to the instant between; a tip without a partner is dropped."""
    if before is None or now is None or not before.tips:
        return None
    earlier = np.array([tip.point for tip in before.tips])
    tips = []
    for tip in now.tips:
        distances = np.hypot(*(earlier - tip.point).T)
        nearest = int(np.argmin(distances))
        if distances[nearest] < SAME_TIP * now.length:
            tips.append(replace(tip, point=(1 - weight) * earlier[nearest] + weight * tip.point))
    farthest = (1 - weight) * before.farthest + weight * now.farthest
    return replace(now, tips=tuple(tips), farthest=farthest)

"""Features at an instant between two exposures of one camera, for cameras that do not expose together."""

from dataclasses import replace

import numpy as np

from common.geometry import Array
from local_site.tracking.silhouette.features import Features
from local_site.tracking.silhouette.medial import MedialLine
from local_site.tracking.silhouette.posture import Posture


def blend(before: Features, now: Features, weight: float) -> Features:
    """The features at a fraction `weight` of the way from one frame of a camera to its next.

    The hand's outline is that of the later frame, to be moved back along with the hand.
    """
    shift = np.zeros(2)
    if before.hand is not None and now.hand is not None:
        shift = (1 - weight) * (before.hand.mean(axis=0) - now.hand.mean(axis=0))
    return replace(
        now,
        forearm=_line(before.forearm, now.forearm, weight),
        root=_line(before.root, now.root, weight),
        forearm_sides=_mix(before.forearm_sides, now.forearm_sides, weight),
        upper_arm=_upper_arm(before.upper_arm, now.upper_arm, weight),
        upper_arm_sides=_mix(before.upper_arm_sides, now.upper_arm_sides, weight),
        wrist=None if before.wrist is None or now.wrist is None else _mix(before.wrist, now.wrist, weight),
        hand_shift=shift,
        guess=_posture(before.guess, now.guess, weight),
    )


def _mix(before: Array, now: Array, weight: float) -> Array:
    result: Array = (1 - weight) * before + weight * now
    return result


def _line(before: MedialLine, now: MedialLine, weight: float) -> MedialLine:
    direction = _mix(before.direction, now.direction, weight)
    return MedialLine(_mix(before.point, now.point, weight), direction / max(float(np.linalg.norm(direction)), 1e-9))


def _upper_arm(before: MedialLine | None, now: MedialLine | None, weight: float) -> MedialLine | None:
    return None if before is None or now is None else _line(before, now, weight)


def _posture(before: Posture, now: Posture, weight: float) -> Posture:
    return Posture(
        shoulder_end=_mix(before.shoulder_end, now.shoulder_end, weight),
        elbow=_mix(before.elbow, now.elbow, weight),
        wrist=_mix(before.wrist, now.wrist, weight),
        hand_end=_mix(before.hand_end, now.hand_end, weight),
        half_width=now.half_width,
    )

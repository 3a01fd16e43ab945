"""The errors of the monocular tracker in figures, with those of the ROBONAUT report beside them; pure."""

from itertools import pairwise
from typing import Any

import numpy as np

from common.geometry import Array, vector_from_rotation
from common.messages.hand import TrackingStatus
from farhand.experiments.hazel_filming import Tracked, joints
from local_site.simulation.hazel import FINGER_M, FOCAL_PX, FOREARM_M, PALM_M

MM = 1e3
JOINTS = ("shoulder", "elbow", "wrist")
FINGER_REACH_M = FOREARM_M + PALM_M + FINGER_M
LOST_ABOVE_MM = 50.0

Figures = dict[str, Any]

REPORT_S: Figures = {
    "frames": 400,
    "shoulder_mm": {"mean": 0.57, "variance": 0.40},
    "elbow_mm": {"mean": 0.50, "variance": 0.26},
    "wrist_mm": {"mean": 0.55, "variance": 0.92},
}
REPORT_C: Figures = {
    "frames": 354,
    "finger_tip_mm": {"mean": 5.70, "variance": 9.92, "least": 0.63, "largest": 18.57},
    "in_the_picture_px": {"mean": 1.10, "variance": 0.59, "least": 0.04, "largest": 3.14},
}


def arm_figures(tracked: Tracked) -> Figures:
    """Errors of all joints, how many frames were lost, and the largest error of a frame that was called tracked."""
    errors = {name: joint_errors(tracked, name) for name in JOINTS}
    sure = np.array([status is TrackingStatus.TRACKED for status in tracked.statuses])
    worst = np.nanmax([np.max(lengths(e)[sure], initial=0.0) for e in errors.values()])
    return {
        "frames": len(tracked.poses),
        **{f"{name}_mm": _spread(lengths(e)) for name, e in errors.items()},
        "lost": sum(pose is None for pose in tracked.poses),
        "degraded": sum(status is TrackingStatus.DEGRADED for status in tracked.statuses),
        "largest_called_tracked_mm": round(float(worst), 3),
        "called_tracked_over_50_mm": int(sum(np.any([lengths(e) > LOST_ABOVE_MM for e in errors.values()], 0) & sure)),
    }


def finger_figures(tracked: Tracked) -> Figures:
    """Errors of the finger tip in space and in the picture."""
    true, measured = (joints(arms, "", FINGER_REACH_M) for arms in (tracked.arms, tracked.poses))
    off_px = FOCAL_PX * (measured[:, :2] / measured[:, 2:] - true[:, :2] / true[:, 2:])
    return {
        "frames": len(true),
        "finger_tip_mm": _spread(MM * lengths(measured - true)),
        "in_the_picture_px": _spread(lengths(off_px)),
        "lost": sum(pose is None for pose in tracked.poses),
    }


def joint_errors(tracked: Tracked, name: str) -> Array:
    """Measured less true place (N, 3) of a joint, mm, NaN where lost."""
    true, measured = (joints(arms, name, FOREARM_M) for arms in (tracked.arms, tracked.poses))
    return MM * (measured - true)


def motions(tracked: Tracked) -> tuple[Array, Array]:
    """True and measured motion from frame to frame (N - 1, 9): shoulder in mm, turns of both links in deg."""
    return _motions(tracked.arms), _motions(tracked.poses)


def lengths(vectors: Array) -> Array:
    """The length (N,) of each row."""
    result: Array = np.linalg.norm(vectors, axis=1)
    return result


def _motions(arms: tuple[Any, ...]) -> Array:
    rows = []
    for before, after in pairwise(arms):
        if before is None or after is None:
            rows.append(np.full(9, np.nan))
            continue
        turns = [
            vector_from_rotation(b @ a.T)
            for a, b in ((before.upper_arm, after.upper_arm), (before.forearm, after.forearm))
        ]
        rows.append(np.concatenate([MM * (after.shoulder - before.shoulder), *np.degrees(turns)]))
    return np.array(rows)


def _spread(values: Array) -> Figures:
    """Mean, variance, least and largest, where there is something."""
    known = values[np.isfinite(values)]
    if not len(known):
        return {}
    figures = {"mean": known.mean(), "variance": known.var(), "least": known.min(), "largest": known.max()}
    return {name: round(float(value), 3) for name, value in figures.items()}

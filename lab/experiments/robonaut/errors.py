"""Errors of the tracked arm against the true one, in figures, with those of the ROBONAUT report; pure."""

from itertools import pairwise

import numpy as np

from common.geometry import Array, vector_from_rotation
from common.messages.hand import TrackingStatus
from lab.experiments.report import Figures, rounded
from lab.experiments.robonaut.footage import Tracked
from local_site.simulation.hazel import FINGER_M, FOCAL_PX, FOREARM_M, JOINTS, PALM_M, PALM_POINT_M, TrueArm
from local_site.tracking.monocular.arm_model import ArmPose

MM = 1e3
FROM_ELBOW_M = {  # along the forearm
    "elbow": 0.0,
    "wrist": FOREARM_M,
    "palm": FOREARM_M + PALM_POINT_M,
    "finger_tip": FOREARM_M + PALM_M + FINGER_M,
}
LOST_ABOVE_MM = 50.0

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
    errors = {name: lengths(errors_mm(tracked, name)) for name in JOINTS}
    statuses = [estimate.status for estimate in tracked.estimates]
    sure = np.array([status is TrackingStatus.TRACKED for status in statuses])
    worst = np.nanmax([np.max(error[sure], initial=0.0) for error in errors.values()])
    return {
        "frames": len(tracked.poses),
        **{f"{name}_mm": _spread(error) for name, error in errors.items()},
        "lost": lost_frames(tracked),
        "degraded": sum(status is TrackingStatus.DEGRADED for status in statuses),
        "largest_called_tracked_mm": rounded(worst),
        "called_tracked_over_50_mm": int(sum(np.any([e > LOST_ABOVE_MM for e in errors.values()], 0) & sure)),
    }


def finger_figures(tracked: Tracked) -> Figures:
    """Errors of the finger tip in space and in the picture."""
    true, measured = true_and_measured(tracked, "finger_tip")
    off_px = FOCAL_PX * (measured[:, :2] / measured[:, 2:] - true[:, :2] / true[:, 2:])
    return {
        "frames": len(true),
        "finger_tip_mm": _spread(MM * lengths(measured - true)),
        "in_the_picture_px": _spread(lengths(off_px)),
        "lost": lost_frames(tracked),
    }


def lost_frames(tracked: Tracked) -> int:
    """In how many frames the arm was not found."""
    return sum(pose is None for pose in tracked.poses)


def true_and_measured(tracked: Tracked, name: str) -> tuple[Array, Array]:
    """True and measured positions (N, 3) of a joint, the palm or the finger tip in the camera's frame, m.

    Measured ones are NaN where the arm was lost.
    """
    true, measured = (np.array([_position(arm, name) for arm in arms]) for arms in (tracked.true_arms, tracked.poses))
    return true, measured


def _position(arm: TrueArm | ArmPose | None, name: str) -> Array:
    if arm is None:
        return np.full(3, np.nan)
    return arm.shoulder if name == "shoulder" else arm.elbow + FROM_ELBOW_M[name] * arm.forearm[:, 2]


def errors_mm(tracked: Tracked, name: str) -> Array:
    """Measured less true positions (N, 3) of the same points, mm; NaN where the arm was lost."""
    true, measured = true_and_measured(tracked, name)
    return MM * (measured - true)


def motions(tracked: Tracked) -> tuple[Array, Array]:
    """True and measured motion from frame to frame (N - 1, 9): shoulder in mm, rotations of both links in deg."""
    true, measured = (
        np.array([_motion(before, after) for before, after in pairwise(arms)])
        for arms in (tracked.true_arms, tracked.poses)
    )
    return true, measured


def lengths(vectors: Array) -> Array:
    """The length (N,) of each row."""
    result: Array = np.linalg.norm(vectors, axis=1)
    return result


def _motion(before: TrueArm | ArmPose | None, after: TrueArm | ArmPose | None) -> Array:
    if before is None or after is None:
        return np.full(9, np.nan)
    links = ((before.upper_arm, after.upper_arm), (before.forearm, after.forearm))
    turns = [vector_from_rotation(b @ a.T) for a, b in links]
    return np.concatenate([MM * (after.shoulder - before.shoulder), *np.degrees(turns)])


def _spread(values: Array) -> Figures:
    """Mean, variance, least and largest, without NaN; empty where nothing is left."""
    known = values[np.isfinite(values)]
    if not len(known):
        return {}
    figures = {"mean": known.mean(), "variance": known.var(), "least": known.min(), "largest": known.max()}
    return {name: rounded(value) for name, value in figures.items()}

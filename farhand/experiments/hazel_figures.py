"""The textured arm filmed and tracked by one camera, and the errors in figures, with those of the ROBONAUT report."""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import cv2
import msgspec
import numpy as np

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_S
from common.geometry import Array, vector_from_rotation
from common.messages.hand import TrackingStatus
from farhand.experiments.report import Figures, Progress, rounded
from local_site.simulation.hazel import (
    FINGER_M,
    FOCAL_PX,
    FOREARM_M,
    FRAMES_PER_S,
    JOINTS,
    PALM_M,
    TrueArm,
    film_camera,
    film_pixel,
)
from local_site.simulation.textured_arm import ArmFilm, LimbPose
from local_site.tracking.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.arm_model import ArmPose
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import View, Views

MM = 1e3
FROM_ELBOW_M = {"elbow": 0.0, "wrist": FOREARM_M, "finger_tip": FOREARM_M + PALM_M + FINGER_M}  # along the forearm
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


@dataclass(frozen=True, slots=True)
class Footage:
    """Pictures of an arm, and the true arm in each, in the camera's frame."""

    pictures: tuple[Image, ...]
    true_arms: tuple[TrueArm, ...]


@dataclass(frozen=True, slots=True)
class Tracked:
    """For each frame the true arm, the tracked pose, both in the camera's frame (None where lost), and the status."""

    true_arms: tuple[TrueArm, ...]
    poses: tuple[ArmPose | None, ...]
    statuses: tuple[TrackingStatus, ...]


def render_footage(film: ArmFilm, arms: Iterable[TrueArm], with_finger: bool, progress: Progress) -> Footage:
    """Render one picture for each arm."""
    cv2.setNumThreads(1)
    pictures, true_arms = [], []
    for arm in arms:
        upper, forearm = arm.limb_poses()
        # The stretched finger moves rigidly with the forearm.
        limbs: tuple[LimbPose, ...] = (upper, forearm, forearm) if with_finger else (upper, forearm)
        pictures.append(film.render(limbs))
        true_arms.append(arm)
        progress()
    return Footage(tuple(pictures), tuple(true_arms))


def with_occluder(footage: Footage, box: tuple[int, int, int, int], frames: range, level: int) -> Footage:
    """A copy with a box (left, top, right, bottom; px) of a grey level (0 to 255) painted over the given frames."""
    left, top, right, bottom = box
    pictures = [picture.copy() for picture in footage.pictures]
    for picture in pictures[frames.start : frames.stop]:
        picture[top:bottom, left:right] = level
    return Footage(tuple(pictures), footage.true_arms)


def track_footage(footage: Footage, config: MonocularConfig, click_px: float) -> Tracked:
    """Track all pictures from the true joints in the first, rounded to multiples of `click_px` (0: not rounded)."""
    first = footage.true_arms[0]
    joints = [film_pixel(point) for point in (first.shoulder, first.elbow, first.wrist)]
    if click_px:
        joints = [(click_px * round(x / click_px), click_px * round(y / click_px)) for x, y in joints]
    start = StartConfig(shoulder_px=joints[0], elbow_px=joints[1], wrist_px=joints[2])
    tracker = MonocularTracker(film_camera(), msgspec.structs.replace(config, start=start))
    poses, statuses = [], []
    for k, picture in enumerate(footage.pictures):
        t_ns = round(k * NS_PER_S / FRAMES_PER_S)
        statuses.append(tracker.track(Views(t_ns, (View(Frame(picture, t_ns, k)),))).status)
        poses.append(tracker.pose)
    return Tracked(footage.true_arms, tuple(poses), tuple(statuses))


def arm_figures(tracked: Tracked) -> Figures:
    """Errors of all joints, how many frames were lost, and the largest error of a frame that was called tracked."""
    errors = {name: lengths(errors_mm(tracked, name)) for name in JOINTS}
    sure = np.array([status is TrackingStatus.TRACKED for status in tracked.statuses])
    worst = np.nanmax([np.max(error[sure], initial=0.0) for error in errors.values()])
    return {
        "frames": len(tracked.poses),
        **{f"{name}_mm": _spread(error) for name, error in errors.items()},
        "lost": sum(pose is None for pose in tracked.poses),
        "degraded": sum(status is TrackingStatus.DEGRADED for status in tracked.statuses),
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
        "lost": sum(pose is None for pose in tracked.poses),
    }


def true_and_measured(tracked: Tracked, name: str) -> tuple[Array, Array]:
    """True and measured positions (N, 3) of a joint or the finger tip in the camera's frame, m; NaN where lost."""
    true, measured = (np.array([_position(arm, name) for arm in arms]) for arms in (tracked.true_arms, tracked.poses))
    return true, measured


def _position(arm: TrueArm | ArmPose | None, name: str) -> Array:
    if arm is None:
        return np.full(3, np.nan)
    return arm.shoulder if name == "shoulder" else arm.elbow + FROM_ELBOW_M[name] * arm.forearm[:, 2]


def errors_mm(tracked: Tracked, name: str) -> Array:
    """Measured less true positions (N, 3) of a joint or the finger tip, mm; NaN where the arm was lost."""
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

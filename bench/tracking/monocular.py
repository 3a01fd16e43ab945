"""The monocular tracker's error against its points and milliseconds, on the synthetic arm like HAZEL-S."""

import time
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from common.cameras.camera import Image
from local_site.calibration.physical_camera import Lens
from local_site.simulation.hazel import FOCAL_PX, FOREARM_M, PRINCIPAL_PX, UPPER_ARM_M, Swing, TrueArm, hazel_film
from local_site.tracking.config import MonocularConfig
from local_site.tracking.monocular.estimator import ACCURATE, LIVE, EstimatorSetting
from local_site.tracking.monocular.frame_tracker import ArmFrameTracker
from local_site.tracking.monocular.pose import ArmPose
from local_site.tracking.monocular.quality import judged

FRAMES, SETTLED = 120, 5
POINTS = (100, 200, 400, 1600, 3200)
MM = 1e3


def measure() -> dict[str, float]:
    """Mean errors in mm and ms per frame by setting; the median is of processor time, the least of wall time."""
    cv2.setNumThreads(1)
    film, arms = hazel_film(), [Swing().arm(k) for k in range(FRAMES)]
    pictures = [film.render(arm.limb_poses()) for arm in arms]
    settings = {"live, 800 points": LIVE, "accurate, 5000 points": ACCURATE}
    settings |= {f"live, {points} points": replace(LIVE, points=points) for points in POINTS}
    figures: dict[str, float] = {}
    for name, setting in settings.items():
        figures |= {f"{name}, {figure}": value for figure, value in _measured(arms, pictures, setting).items()}
    return figures


def _measured(arms: Sequence[TrueArm], pictures: Sequence[Image], setting: EstimatorSetting) -> dict[str, float]:
    """Fit, judgement and learning timed; frames that are lost end the run."""
    follower = ArmFrameTracker(Lens(FOCAL_PX, FOCAL_PX, *PRINCIPAL_PX), MonocularConfig(), setting)
    first = arms[0]
    follower.begin(pictures[0], ArmPose(first.shoulder, first.upper_arm, first.forearm, UPPER_ARM_M))
    errors, wall_ms, processor_ms = [], [], []
    for arm, picture in zip(arms[1:], pictures[1:], strict=True):
        wall, processor = time.perf_counter(), time.process_time()
        expected = follower.expected()
        fit = None if expected is None else follower.fit(picture, expected)
        if fit is None or judged(fit).spread is None:
            break
        follower.keep(picture, fit)
        wall_ms.append(MM * (time.perf_counter() - wall))
        processor_ms.append(MM * (time.process_time() - processor))
        errors.append(_off_mm(fit.state.pose, arm))
    shoulder, elbow, wrist = np.mean(errors, axis=0)
    return {
        "frames": float(len(errors)),
        "shoulder mm": float(shoulder),
        "elbow mm": float(elbow),
        "wrist mm": float(wrist),
        "median ms": float(np.median(processor_ms[SETTLED:])),
        "least ms": float(np.min(wall_ms[SETTLED:])),
    }


def _off_mm(pose: ArmPose, arm: TrueArm) -> list[float]:
    wrist = pose.on_forearm(np.array([0.0, 0.0, FOREARM_M]))
    pairs = (pose.shoulder, arm.shoulder), (pose.elbow, arm.elbow), (wrist, arm.wrist)
    return [MM * float(np.linalg.norm(measured - true)) for measured, true in pairs]

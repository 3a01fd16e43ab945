"""The monocular tracker's error and time per frame for several numbers of points, on a synthetic arm like HAZEL-S."""

import time
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from common.cameras.camera import Image
from local_site.calibration.physical_camera import Lens
from local_site.simulation.hazel import FOCAL_PX, FOREARM_M, PRINCIPAL_PX, UPPER_ARM_M, Swing, TrueArm, hazel_film
from local_site.tracking.config import MonocularConfig
from local_site.tracking.monocular.arm_model import ArmPose
from local_site.tracking.monocular.estimator import ACCURATE, LIVE, EstimatorSetting, judged
from local_site.tracking.monocular.frame_tracker import ArmFrameTracker

FRAMES = 120
WARM_UP_FRAMES = 5  # left out of the times
POINTS = (100, 200, 400, 1600, 3200)
MM_PER_M = MS_PER_S = 1e3


def measure() -> dict[str, float]:
    """By setting: the mean errors in mm, and per frame the median processor time and the minimum wall time in ms."""
    cv2.setNumThreads(1)
    film, arms = hazel_film(), [Swing().arm(k) for k in range(FRAMES)]
    images = [film.render(arm.limb_poses()) for arm in arms]
    settings = {"live, 800 points": LIVE, "accurate, 5000 points": ACCURATE}
    settings |= {f"live, {points} points": replace(LIVE, points=points) for points in POINTS}
    figures: dict[str, float] = {}
    for name, setting in settings.items():
        figures |= {f"{name}, {figure}": value for figure, value in _measured(arms, images, setting).items()}
    return figures


def _measured(arms: Sequence[TrueArm], images: Sequence[Image], setting: EstimatorSetting) -> dict[str, float]:
    """The time covers fitting, the verdict on the fit, and learning; the first lost frame ends the run."""
    tracker = ArmFrameTracker(Lens(FOCAL_PX, FOCAL_PX, *PRINCIPAL_PX), MonocularConfig(), setting)
    first = arms[0]
    tracker.begin(images[0], ArmPose(first.shoulder, first.upper_arm, first.forearm, UPPER_ARM_M))
    errors_mm, wall_ms, processor_ms = [], [], []
    for arm, image in zip(arms[1:], images[1:], strict=True):
        wall, processor = time.perf_counter(), time.process_time()
        expected = tracker.expected()
        fit = None if expected is None else tracker.fit(image, expected)
        if fit is None or judged(fit).spread is None:
            break
        tracker.keep(image, fit)
        wall_ms.append(MS_PER_S * (time.perf_counter() - wall))
        processor_ms.append(MS_PER_S * (time.process_time() - processor))
        pose = fit.state.pose
        wrist = pose.on_forearm(np.array([0.0, 0.0, FOREARM_M]))
        pairs = (pose.shoulder, arm.shoulder), (pose.elbow, arm.elbow), (wrist, arm.wrist)
        errors_mm.append([MM_PER_M * float(np.linalg.norm(measured - true)) for measured, true in pairs])
    means = zip(("shoulder mm", "elbow mm", "wrist mm"), np.mean(errors_mm, axis=0).tolist(), strict=True)
    return {
        "frames": float(len(errors_mm)),
        **dict(means),
        "median ms": float(np.median(processor_ms[WARM_UP_FRAMES:])),
        "least ms": float(np.min(wall_ms[WARM_UP_FRAMES:])),
    }

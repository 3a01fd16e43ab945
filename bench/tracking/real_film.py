"""A real arm before two real cameras: how often it is tracked, and how far its tips are from labels made by eye.

There is no truth in 3D; what else can be checked is that the forearm keeps its length and that the views agree.
"""

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from msgspec import convert

from bench.tracking.scenes import RECORDINGS
from common.cameras.sources import open_camera
from common.geometry import Array
from common.messages.hand import TrackingStatus
from farhand.tracking.recorded_pairs import RecordedPairs
from local_site.calibration.rig import CameraCalibration, Projection, Rig
from local_site.calibration.triangulation import project
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views

REAL = RECORDINGS.parent / "real"
NAMES = ("cam0", "cam1")
SQUARE_M = 0.043  # of the chessboard, in whose squares the calibration is
ANYWHERE = (-5.0, -5.0, -5.0), (5.0, 5.0, 5.0)  # m; the calibrated volume is not known
BEFORE_HAND = 13  # pairs in which a picture does not show the whole hand yet
LABELLED = {"index": "index_tip", "thumb": "thumb_tip", "wrist": "wrist"}
WITH_POINTS = (TrackingStatus.TRACKED, TrackingStatus.DEGRADED)

Labels = dict[str, dict[str, dict[str, list[float] | None]]]


class RealCamera:
    """One camera of the film: its projection (3, 4), and its pictures and pixels without distortion."""

    def __init__(self, folder: Path, number: int) -> None:
        intrinsic, pose = _numbers(folder / f"c{number}.dat"), _numbers(folder / f"rot_trans_c{number}.dat")
        self._matrix, self._distortion = np.array(intrinsic[:3]), np.array(intrinsic[3])
        translation_m = SQUARE_M * np.array([row[0] for row in pose[3:6]])
        self.projection: Array = self._matrix @ np.column_stack([np.array(pose[:3]), translation_m])

    def undistorted(self, view: View) -> View:
        """The view with the picture that a pinhole camera would have taken."""
        picture = cv2.undistort(view.current.image, self._matrix, self._distortion)
        return replace(view, current=replace(view.current, image=np.asarray(picture, dtype=np.uint8)))

    def undistorted_pixel(self, pixel: Sequence[float]) -> Array:
        """The pixel (2,) for which the projection holds, of one in the film."""
        moved = cv2.undistortPoints(np.array([[pixel]], np.float64), self._matrix, self._distortion, P=self._matrix)
        return np.asarray(moved[0, 0], dtype=np.float64)


def measure_real(folder: Path = REAL) -> dict[str, float]:
    """The learned tracker's figures on the film by name; NotInstalledError without its models."""
    cameras = [RealCamera(folder, number) for number in range(len(NAMES))]
    tracker = make_tracker(_rig(cameras), TrackingConfig(method="learned"))
    estimates, processor_ms = [], []
    for views in _pairs(folder, cameras):
        start = time.process_time()
        estimates.append(tracker.track(views))
        processor_ms.append(1e3 * (time.process_time() - start))
    labels: Labels = json.loads((folder / "labels.json").read_bytes())
    return {
        **_statuses(estimates[BEFORE_HAND:]),
        **{f"{point}, median px from labels": _off_px(point, estimates, labels, cameras) for point in LABELLED},
        **_consistency(estimates),
        "median processor ms per pair": float(np.median(processor_ms)),
        "p95 processor ms per pair": float(np.percentile(processor_ms, 95)),
    }


def _numbers(path: Path) -> list[list[float]]:
    """The rows of numbers in a file, without its headings and remarks."""
    lines = (line.split() for line in path.read_text(encoding="ascii").splitlines())
    return [[float(word) for word in words] for words in lines if words and words[0][0] in "-0123456789"]


def _rig(cameras: Sequence[RealCamera]) -> Rig:
    calibrations = tuple(
        CameraCalibration(name, convert(camera.projection.tolist(), Projection), reprojection_rms_px=0.5)
        for name, camera in zip(NAMES, cameras, strict=True)
    )
    return Rig(calibrations, *ANYWHERE, error_rms=(0.001, 0.001, 0.001), created="for measuring")


def _pairs(folder: Path, cameras: Sequence[RealCamera]) -> Iterator[Views]:
    with (
        closing(open_camera(str(folder / f"{NAMES[0]}.mp4"), NAMES[0])) as left,
        closing(open_camera(str(folder / f"{NAMES[1]}.mp4"), NAMES[1])) as right,
    ):
        for views in RecordedPairs(left, right):
            seen = zip(cameras, views.views, strict=True)
            yield Views(views.t_ns, tuple(camera.undistorted(view) for camera, view in seen))


def _statuses(estimates: Sequence[ArmEstimate]) -> dict[str, float]:
    with_points = sum(e.status in WITH_POINTS and e.index is not None for e in estimates)
    tracked = sum(e.status is TrackingStatus.TRACKED for e in estimates)
    return {
        "pairs with the whole hand in both views": float(len(estimates)),
        "tracked or degraded with points %": 100.0 * with_points / len(estimates),
        "tracked %": 100.0 * tracked / len(estimates),
    }


def _off_px(point: str, estimates: Sequence[ArmEstimate], labels: Labels, cameras: Sequence[RealCamera]) -> float:
    """The median distance in px from the labels of a point."""
    off = []
    for number, views in labels.items():
        found = getattr(estimates[int(number)], point)
        for name, camera in zip(NAMES, cameras, strict=True):
            label = views[name][LABELLED[point]]
            if label is not None and found is not None:
                off.append(project(camera.projection, found) - camera.undistorted_pixel(label[:2]))
    return float(np.median(np.linalg.norm(off, axis=1)))


def _consistency(estimates: Sequence[ArmEstimate]) -> dict[str, float]:
    limbs = [e.elbow - e.wrist for e in estimates if e.elbow is not None and e.wrist is not None]
    lengths = np.linalg.norm(limbs, axis=1)
    residuals = [e.residual_px for e in estimates if e.residual_px is not None]
    return {
        "forearm's length, sd %": float(100.0 * np.std(lengths) / np.mean(lengths)),
        "residual between the views, median px": float(np.median(residuals)),
    }

"""A real arm before two real cameras: how often it is tracked, and how far its tips are from labels made by eye.

There is no truth in 3D; what else can be checked is that the forearm keeps its length and that the views agree.
"""

import json
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import cv2
import numpy as np

from common.cameras.sources import open_camera
from common.geometry import Array
from common.messages.hand import FOUND, TrackingStatus
from farhand.tracking.recorded_pairs import RecordedPairs
from lab.films.scenes import RECORDINGS
from local_site.calibration.control_points import ControlPoints
from local_site.calibration.rig import Rig
from local_site.calibration.solve import solve_rig
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, Views

REAL = RECORDINGS.parent / "real"
NAMES = ("cam0", "cam1")  # left and right
SIZE_PX, FIELD = (720, 720), 0.32
REACH_M, POINTS_A_SIDE = 0.45, 7  # of the points for the calibration, around where both cameras look
SQUARE_M = 0.043  # of the chessboard, in whose squares the calibration is
BEFORE_HAND = 13  # pairs in which a picture does not show the whole hand yet
LABELLED = {"index": "index_tip", "thumb": "thumb_tip", "wrist": "wrist"}

Labels = dict[str, dict[str, dict[str, list[float] | None]]]


class RealCamera:
    """One camera of the film, as its makers have calibrated it: with five coefficients of distortion."""

    def __init__(self, folder: Path, name: str) -> None:
        number = name.removeprefix("cam")
        intrinsic, pose = _numbers(folder / f"c{number}.dat"), _numbers(folder / f"rot_trans_c{number}.dat")
        self._matrix, self._distortion = np.array(intrinsic[:3]), np.array(intrinsic[3])
        self._rotation = np.array(pose[:3])
        self._translation_m = SQUARE_M * np.array([row[0] for row in pose[3:6]])

    @property
    def ray(self) -> tuple[Array, Array]:
        """The camera's centre (3,) in m and the direction (3,) in which it looks."""
        return -self._rotation.T @ self._translation_m, self._rotation[2]

    def pixels(self, points: Array) -> Array:
        """Project points (N, 3) in m to where the camera sees them (N, 2), NaN outside its picture."""
        turn, _ = cv2.Rodrigues(self._rotation)
        seen, _ = cv2.projectPoints(points, turn, self._translation_m, self._matrix, self._distortion)
        x, y, z = (points @ self._rotation.T + self._translation_m).T
        inside = (z > 0) & (np.maximum(np.abs(x), np.abs(y)) < FIELD * z)  # beyond it, the distortion folds back
        return np.where(inside[:, None], np.asarray(seen[:, 0], dtype=np.float64), np.nan)


def measure_real(folder: Path = REAL) -> dict[str, float]:
    """The learned tracker's figures on the film by name; NotInstalledError without its models."""
    cameras = [RealCamera(folder, name) for name in NAMES]
    tracker = make_tracker(_rig(cameras), TrackingConfig(method="learned"))
    estimates, processor_ms = [], []
    for views in _pairs(folder):
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
    """The rig as Farhand calibrates it, from points in the space that both cameras see."""
    (first, along), (second, across) = (camera.ray for camera in cameras)
    nearest = np.linalg.lstsq(np.column_stack([along, -across]), second - first, rcond=None)[0]
    middle = 0.5 * (first + nearest[0] * along + second + nearest[1] * across)
    offsets = np.linspace(-REACH_M, REACH_M, POINTS_A_SIDE)
    points = middle + np.stack(np.meshgrid(offsets, offsets, offsets), axis=-1).reshape(-1, 3)
    labels = tuple(f"point {k}" for k in range(len(points)))
    pixels = tuple(camera.pixels(points) for camera in cameras)
    control = ControlPoints(points, pixels, labels, "the real film", (SIZE_PX, SIZE_PX))
    return solve_rig(control, created="for measuring")


def _pairs(folder: Path) -> Iterator[Views]:
    with (
        closing(open_camera(str(folder / f"{NAMES[0]}.mp4"), NAMES[0])) as left,
        closing(open_camera(str(folder / f"{NAMES[1]}.mp4"), NAMES[1])) as right,
    ):
        yield from RecordedPairs(left, right)


def _statuses(estimates: Sequence[ArmEstimate]) -> dict[str, float]:
    with_points = sum(e.status in FOUND and e.index is not None for e in estimates)
    tracked = sum(e.status is TrackingStatus.TRACKED for e in estimates)
    return {
        "pairs with the whole hand in both views": float(len(estimates)),
        "tracked or degraded with points %": 100.0 * with_points / len(estimates),
        "tracked %": 100.0 * tracked / len(estimates),
    }


def _off_px(point: str, estimates: Sequence[ArmEstimate], labels: Labels, cameras: Sequence[RealCamera]) -> float:
    """The median distance in px from the labels of a point, in the pictures as they were taken."""
    off = []
    for number, views in labels.items():
        found = getattr(estimates[int(number)], point)
        for name, camera in zip(NAMES, cameras, strict=True):
            label = views[name][LABELLED[point]]
            if label is not None and found is not None:
                off.append(camera.pixels(found[None])[0] - label[:2])
    return float(np.median(np.linalg.norm(off, axis=1)))


def _consistency(estimates: Sequence[ArmEstimate]) -> dict[str, float]:
    limbs = [e.elbow - e.wrist for e in estimates if e.elbow is not None and e.wrist is not None]
    lengths = np.linalg.norm(limbs, axis=1)
    residuals = [e.residual_px for e in estimates if e.residual_px is not None]
    return {
        "forearm's length, sd %": float(100.0 * np.std(lengths) / np.mean(lengths)),
        "residual between the views, median px": float(np.median(residuals)),
    }

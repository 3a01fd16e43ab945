"""Tracking a recording: two or more cameras in, a line of JSON per pair out; causal and unsmoothed."""

import math
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TextIO

import cv2
import msgspec
import numpy as np

from common.cameras.camera import Camera, Frame
from common.clock import NS_PER_MS
from common.errors import CameraError
from common.geometry import Array
from common.messages import TrackingStatus, Vector3
from local_site.calibration.drift import DriftConfig
from local_site.calibration.rig import Rig
from local_site.drift_watch import DriftWatch
from local_site.gesture import OpenHand, observe
from local_site.tracking.annotate import annotate
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import ArmEstimate, View, Views

POINTS = ("elbow", "wrist", "index", "thumb")


class TrackLine(msgspec.Struct, frozen=True, kw_only=True):
    """One pair of a recording: points (m, operator frame) and how sure they are, null where unknown.

    `sigma` in m is the root of the covariance's trace: the rms length of the point's 3D error, not of one axis.
    """

    frame: int
    t_ns: int
    status: TrackingStatus
    reason: str
    elbow: Vector3 | None
    wrist: Vector3 | None
    index: Vector3 | None
    thumb: Vector3 | None
    sigma: dict[str, float | None]
    thumb_inferred: bool
    hand_open: bool
    gripper_toggles: int
    ms: float


@dataclass
class Summary:
    """What a recording gave: pairs, how many of each status, how often each point was found, toggles, ms per pair.

    `drift` is the sentence of the drift alarm when it rang first, if it did.
    """

    pairs: int = 0
    statuses: dict[TrackingStatus, int] = field(default_factory=lambda: dict.fromkeys(TrackingStatus, 0))
    found: dict[str, int] = field(default_factory=lambda: dict.fromkeys(POINTS, 0))
    gripper_toggles: int = 0
    ms: list[float] = field(default_factory=list)
    reasons: Counter[str] = field(default_factory=Counter)
    drift: str | None = None

    def add(self, line: TrackLine) -> None:
        """Count one pair."""
        self.pairs += 1
        self.statuses[line.status] += 1
        self.reasons[line.reason] += 1
        for name in POINTS:
            self.found[name] += getattr(line, name) is not None
        self.gripper_toggles = line.gripper_toggles
        self.ms.append(line.ms)

    def warn_of_drift(self, sentence: str) -> None:
        """Keep what the drift alarm says."""
        self.drift = sentence


def track_recording(
    rig: Rig,
    left_camera: Camera,
    right_camera: Camera,
    out: Path,
    annotate_dir: Path | None,
    progress: Callable[[int], None],
    tracking: TrackingConfig | None = None,
    also: Sequence[Camera] = (),
) -> Summary:
    """Track all pairs of two cameras, write a line each to `out` and, if asked, annotated pairs as PNG.

    `also` are a third and a fourth camera; the cameras stand in the rig's order.
    `progress` is called with the number of pairs done. Raises CameraError when no pair comes or a file cannot be
    written.
    """
    tracker, hand, summary = make_tracker(rig, tracking or TrackingConfig()), OpenHand(), Summary()
    drift = DriftWatch(rig, DriftConfig(), summary.warn_of_drift)
    try:
        if annotate_dir is not None:
            annotate_dir.mkdir(parents=True, exist_ok=True)
        with _written_at_end(out) as lines:
            for views in pair_views(left_camera, right_camera, *also):
                start_ns = time.perf_counter_ns()
                estimate = drift.judge(tracker.track(views))
                ms = (time.perf_counter_ns() - start_ns) / NS_PER_MS
                hand = observe(hand, estimate.hand_open if estimate.wrist is not None else None, views.t_ns)
                summary.add(_write(lines, summary.pairs, estimate, hand, ms))
                if annotate_dir is not None:
                    _save_annotated(annotate_dir / f"{summary.pairs - 1:06d}.png", rig, views, estimate)
                progress(summary.pairs)
    except OSError as error:
        raise CameraError(f"cannot write the track: {error}; choose a place that can be written") from error
    if not summary.pairs:
        names = " and ".join(camera.name for camera in (left_camera, right_camera, *also))
        raise CameraError(f"{names} gave no pair of frames of a common time")
    return summary


@contextmanager
def _written_at_end(out: Path) -> Iterator[TextIO]:
    """A file that takes its place once something is in it, so that a failure leaves an earlier track alone."""
    part = out.with_name(f"{out.name}.part")
    try:
        with part.open("w", encoding="utf-8", buffering=1) as lines:
            yield lines
    finally:
        if part.exists() and part.stat().st_size:
            part.replace(out)
        else:
            part.unlink(missing_ok=True)


def pair_views(left: Camera, *others: Camera) -> Iterator[Views]:
    """Views at the instants of the left camera's frames, until any camera ends.

    The other cameras' measurements are interpolated between the two exposures around the instant.
    """
    followers = [_Follower(camera) for camera in others]
    while (frame := left.read()) is not None:
        found = [follower.at(frame.capture_ns) for follower in followers]
        views = [view for view in found if view is not None]
        if len(views) < len(found):
            return
        yield Views(frame.capture_ns, (View(frame), *views))


class _Follower:
    """A camera that is read as far as the instants of another ask for."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera
        self._previous: Frame | None = None
        self._current = camera.read()

    def at(self, t_ns: int) -> View | None:
        """The view of an instant no earlier than the last; None once the camera has ended."""
        while self._current is not None and self._current.capture_ns < t_ns:
            self._previous, self._current = self._current, self._camera.read()
        return None if self._current is None else _between(self._previous, self._current, t_ns)


def _between(previous: Frame | None, current: Frame, t_ns: int) -> View:
    if previous is None or current.capture_ns == t_ns:
        return View(current)
    weight = (t_ns - previous.capture_ns) / (current.capture_ns - previous.capture_ns)
    return View(current, previous, weight)


def _write(lines: TextIO, frame: int, estimate: ArmEstimate, hand: OpenHand, ms: float) -> TrackLine:
    line = TrackLine(
        frame=frame,
        t_ns=estimate.t_ns,
        status=estimate.status,
        reason=estimate.reason,
        elbow=_vector(estimate.elbow),
        wrist=_vector(estimate.wrist),
        index=_vector(estimate.index),
        thumb=_vector(estimate.thumb),
        sigma={name: _sigma(estimate, name) for name in POINTS},
        thumb_inferred=estimate.thumb_inferred,
        hand_open=hand.is_open,
        gripper_toggles=hand.toggles,
        ms=round(ms, 3),
    )
    lines.write(msgspec.json.encode(line).decode() + "\n")
    return line


def _sigma(estimate: ArmEstimate, name: str) -> float | None:
    """The rms length of a point's 3D error, m."""
    if getattr(estimate, name) is None or name not in estimate.covariances:
        return None
    variance = float(np.trace(estimate.covariances[name]))
    return round(math.sqrt(variance), 6) if 0 <= variance < math.inf else None


def _vector(point: Array | None) -> Vector3 | None:
    if point is None:
        return None
    x, y, z = (round(float(value), 6) for value in point)
    return x, y, z


def _save_annotated(path: Path, rig: Rig, views: Views, estimate: ArmEstimate) -> None:
    in_camera_order = enumerate(zip(views.views, rig.matrices, strict=True))
    pictures = [annotate(view.current.image, estimate, k, matrix) for k, (view, matrix) in in_camera_order]
    height = max(picture.shape[0] for picture in pictures)
    padded = [np.pad(p, ((0, height - p.shape[0]), (0, 0), (0, 0))) for p in pictures]
    if not cv2.imwrite(str(path), np.hstack(padded)):
        raise OSError(f"{path} was not written")

"""Tracking a recording: two or more cameras in, a line of JSON per pair out; causal and unsmoothed."""

import math
import os
import re
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path
from typing import TextIO

import msgspec
import numpy as np

from common.cameras.camera import Camera, Image
from common.cameras.images import write_image
from common.clock import NS_PER_MS
from common.errors import CameraError
from common.geometry import Array
from common.messages.base import Vector3
from common.messages.hand import TrackingStatus
from farhand.tracking.recorded_pairs import RecordedPairs
from local_site.calibration.rig import Rig
from local_site.config import LocalConfig
from local_site.samples.hand_sample import OpenHand
from local_site.tracking.annotate import annotate
from local_site.tracking.choice import make_tracker
from local_site.tracking.drift import DriftWatch
from local_site.tracking.tracker import ArmEstimate, Views

LEARNED_SO_FAR = re.compile(r" \(\d+ of \d+ pairs\)")
POINTS = ("elbow", "wrist", "index", "thumb")


class TrackLine(msgspec.Struct, frozen=True, kw_only=True):
    """One pair of a recording: points (m, operator frame) and their uncertainty, null where unknown.

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
    palm: Vector3 | None = None


@dataclass
class Summary:
    """A recording's result: pairs, how many of each status, how often each point was found, toggles, ms per pair.

    `drift` is the sentence of the first drift alarm, if there was one; `left_out` names what was not tracked because a
    camera ended before another.
    """

    pairs: int = 0
    statuses: dict[TrackingStatus, int] = field(default_factory=lambda: dict.fromkeys(TrackingStatus, 0))
    found: dict[str, int] = field(default_factory=lambda: dict.fromkeys(POINTS, 0))
    gripper_toggles: int = 0
    ms: list[float] = field(default_factory=list)
    reasons: Counter[str] = field(default_factory=Counter)
    drift: str | None = None
    left_out: str = ""

    def add(self, line: TrackLine) -> None:
        """Count one pair."""
        self.pairs += 1
        self.statuses[line.status] += 1
        self.reasons[LEARNED_SO_FAR.sub("", line.reason)] += 1
        for name in POINTS:
            self.found[name] += getattr(line, name) is not None
        self.gripper_toggles = line.gripper_toggles
        self.ms.append(line.ms)

    def warn_of_drift(self, sentence: str) -> None:
        """Keep the drift alarm's sentence."""
        self.drift = sentence


def track_recording(
    rig: Rig,
    left_camera: Camera,
    others: Sequence[Camera],
    out: Path,
    annotate_dir: Path | None,
    progress: Callable[[int], None],
    site: LocalConfig | None = None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Summary:
    """Track all pairs of two cameras, write a line each to `out` and, if asked, annotated pairs as PNG.

    `others` are the cameras besides the left one, none to three, in the rig's order. Of the local site's configuration,
    tracking, drift alarm and gesture are used. `progress` is called with the number of pairs done. Raises CameraError
    when no pair comes, a picture has the wrong size, or a file cannot be written.
    """
    recording = _Recording(rig, site or LocalConfig(), annotate_dir)
    try:
        pairs = RecordedPairs(left_camera, *others)
        with _written_at_end(out) as lines:
            for views in takewhile(lambda _: not should_stop(), pairs):
                recording.track(views, lines)
                progress(recording.summary.pairs)
    except OSError as error:
        raise CameraError(f"cannot write the track: {error}; choose a folder that can be written") from error
    summary = recording.summary
    if not summary.pairs and not should_stop():
        why = pairs.left_out.partition(";")[0] or "no camera gave a frame"
        raise CameraError(f"no pair of frames of a common time: {why}; give recordings that hold frames")
    summary.left_out = pairs.left_out
    return summary


class _Recording:
    """A recording being tracked: each pair's views to a line, and the summary of all."""

    def __init__(self, rig: Rig, site: LocalConfig, annotate_dir: Path | None) -> None:
        self.summary = Summary()
        self._rig = rig
        self._annotate_dir = annotate_dir
        self._tracker = make_tracker(rig, site.tracking)
        self._drift = DriftWatch(rig, site.drift, self.summary.warn_of_drift)
        self._hand, self._gesture = OpenHand(), site.gesture
        self._sizes = [camera.size_px for camera in rig.cameras]

    def track(self, views: Views, lines: TextIO) -> None:
        """Track the views of one instant and write its line, and its picture if asked."""
        self._refuse_other_sizes(views)
        start_ns = time.perf_counter_ns()
        estimate = self._drift.judge(self._tracker.track(views))
        ms = (time.perf_counter_ns() - start_ns) / NS_PER_MS
        self._hand = self._hand.observe(estimate, self._gesture)
        self.summary.add(_write(lines, self.summary.pairs, estimate, self._hand, ms))
        if self._annotate_dir is not None:
            name = f"{self.summary.pairs - 1:06d}"
            write_image(self._annotate_dir, name, _annotated(self._rig, views, estimate))

    def _refuse_other_sizes(self, views: Views) -> None:
        """CameraError for a picture of another size than calibrated or, where that is unknown, than the first."""
        for k, (view, camera) in enumerate(zip(views.views, self._rig.cameras, strict=True)):
            height, width = view.current.image.shape[:2]
            expected = self._sizes[k] or (width, height)
            self._sizes[k] = expected
            if (width, height) != expected:
                expectation = "it was calibrated at" if camera.size_px else "its first was"
                raise CameraError(
                    f"camera {camera.name}: its picture {view.current.seq} is {width}x{height}, but {expectation} "
                    "{}x{}; give pictures of one size, that of the calibration".format(*expected)
                )


@contextmanager
def _written_at_end(out: Path) -> Iterator[TextIO]:
    """A file that replaces an earlier one once it has a line, so that a failure leaves the earlier track alone."""
    if out.exists() and not out.is_file():
        with out.open("w", encoding="utf-8") as lines:
            yield lines
        return
    out = out.resolve()
    part = out.with_name(f"{out.name}.part")
    try:
        with part.open("w", encoding="utf-8", buffering=1) as lines:
            yield lines
    finally:
        text = part.read_bytes() if part.exists() else b""
        whole = text.rfind(b"\n") + 1
        if whole < len(text):
            os.truncate(part, whole)  # an incomplete last line, as of a full disk
        if whole:
            part.replace(out)
        else:
            part.unlink(missing_ok=True)


def _write(lines: TextIO, frame: int, estimate: ArmEstimate, hand: OpenHand, ms: float) -> TrackLine:
    line = TrackLine(
        frame=frame,
        t_ns=estimate.t_ns,
        status=estimate.status,
        reason=estimate.reason,
        sigma={name: _sigma(estimate, name) for name in POINTS},
        thumb_inferred=estimate.thumb_inferred,
        hand_open=hand.is_open,
        gripper_toggles=hand.toggles,
        ms=round(ms, 3),
        **{name: _vector(getattr(estimate, name)) for name in (*POINTS, "palm")},
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


def _annotated(rig: Rig, views: Views, estimate: ArmEstimate) -> Image:
    """All views side by side with what was found in them."""
    cameras = enumerate(zip(views.views, rig.matrices, strict=True))
    pictures = [annotate(view.current.image, estimate, k, matrix) for k, (view, matrix) in cameras]
    height = max(picture.shape[0] for picture in pictures)
    padded = [np.pad(p, ((0, height - p.shape[0]), (0, 0), (0, 0))) for p in pictures]
    return np.hstack(padded)

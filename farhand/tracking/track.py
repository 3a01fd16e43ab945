"""Tracking a recording: one to four cameras in, a pair at a time to its results; causal and unsmoothed."""

import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from itertools import takewhile

from common.cameras.camera import Camera
from common.cameras.sources import damage_of
from common.clock import NS_PER_MS, NS_PER_S
from common.errors import CameraError
from farhand.tracking.causes import Causes
from farhand.tracking.recorded_pairs import RecordedPairs
from farhand.tracking.results.tracked_pair import Result, TrackedPair
from farhand.tracking.summary import Summary
from farhand.tracking.track_line import track_line
from local_site.calibration.rig import Rig
from local_site.config import LocalConfig
from local_site.samples.hand_sample import OpenHand
from local_site.tracking.choice import make_tracker
from local_site.tracking.drift import DriftWatch
from local_site.tracking.rig_fit import RigFit
from local_site.tracking.tracker import Views


def track_recording(
    rig: Rig,
    left_camera: Camera,
    others: Sequence[Camera],
    results: Iterable[Result],
    progress: Callable[[int], None],
    site: LocalConfig | None = None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Summary:
    """Track all pairs of two cameras, and give each to every result.

    `others` are the cameras besides the left one, none to three, in the rig's order. Of the local site's configuration,
    tracking, drift alarm and gesture are used. `progress` is called with the number of pairs done. Raises CameraError
    when no pair comes, a picture has the wrong size, or a file cannot be written.
    """
    recording = _Recording(rig, site or LocalConfig())
    try:
        with ExitStack() as opened:
            takers = [opened.enter_context(result) for result in results]
            pairs = RecordedPairs(left_camera, *others)
            for views in takewhile(lambda _: not should_stop(), pairs):
                tracked = recording.track(views)
                for take in takers:
                    take(tracked)
                recording.summary.add(tracked.line)
                progress(recording.summary.pairs)
    except OSError as error:
        raise CameraError(f"cannot write the track: {error}; choose a folder that can be written") from error
    summary = recording.summary
    if not summary.pairs and not should_stop():
        why = pairs.left_out.partition(";")[0] or "no camera gave a frame"
        raise CameraError(f"no pair of frames of a common time: {why}; give recordings that hold frames")
    recording.finish()
    summary.left_out = pairs.left_out
    summary.damages = tuple(filter(None, map(damage_of, (left_camera, *others))))
    return summary


class _Recording:
    """A recording being tracked: each pair's views to its line, and the summary of all."""

    def __init__(self, rig: Rig, site: LocalConfig) -> None:
        self.summary = Summary(causes=Causes([camera.name for camera in rig.cameras]))
        self._rig = rig
        self._tracker = make_tracker(rig, site.tracking)
        self._drift = DriftWatch(rig, site.drift, self.summary.warn_of_drift)
        self._fit = RigFit(rig, site.drift.misfit_sigmas)
        self._hand, self._gesture = OpenHand(), site.gesture
        self._sizes = [camera.size_px for camera in rig.cameras]
        self._first_ns: int | None = None

    def track(self, views: Views) -> TrackedPair:
        """Track the views of one instant; CameraError for a picture of another size."""
        self._refuse_other_sizes(views)
        start_ns = time.perf_counter_ns()
        tracked = self._tracker.track(views)
        self._fit.add(tracked)
        estimate = self._drift.judge(tracked)
        ms = (time.perf_counter_ns() - start_ns) / NS_PER_MS
        self._hand = self._hand.observe(estimate, self._gesture)
        self._first_ns = views.t_ns if self._first_ns is None else self._first_ns
        line = track_line(self.summary.pairs, estimate, self._hand, ms)
        return TrackedPair(self._rig, views, estimate, line, (views.t_ns - self._first_ns) / NS_PER_S)

    def finish(self) -> None:
        """Judge the rig by all pairs: a short recording ends before the drift alarm can say anything."""
        self.summary.misfit = self._fit.problem()

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

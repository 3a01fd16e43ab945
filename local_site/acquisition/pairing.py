"""Pairs the frames of several cameras to views of common instants; pure."""

from collections import deque
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct

from common.cameras.camera import Frame
from common.clock import NS_PER_MS, NS_PER_S
from local_site.tracking.tracker import View, Views

HISTORY = 4
LEAST_STEP = 0.25
SLOW = 0.9  # of the longest wait for views: pictures further apart come too late whenever one takes a little longer


class PairingConfig(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When frames of several cameras belong together, and when a camera is refused."""

    tolerance_ms: Annotated[
        float, Meta(ge=0, le=20, description="exposures no further apart count as one instant, else interpolate")
    ] = 2.0
    max_skew_ms: Annotated[
        float, Meta(gt=0, le=500, description="newest exposures further apart are refused; about 1.5 frame periods")
    ] = 50.0
    stale_ms: Annotated[float, Meta(gt=0, le=5000, description="a camera silent for this long is stale")] = 500.0
    longest_wait_ms: Annotated[
        float,
        Meta(
            ge=50,
            le=400,
            description="without new pictures for this long the hand is lost, ms; cameras of less than 11 pictures a "
            "second need more, and the remote site a longer safety.t_soft_ms",
        ),
    ] = 100.0
    frozen_frames: Annotated[
        int, Meta(ge=1, le=100, description="this many repeats of one picture are a frozen camera")
    ] = 5


class Pairing:
    """Finds the newest instant that the exposures of all cameras enclose; each instant is given once, in order.

    Cameras out of phase give up to an instant each a period, none within a quarter period of the last.
    Frames are interpolated between two exposures, never beyond the newest. Times are ns on the cameras' clock.
    """

    def __init__(self, names: Sequence[str], config: PairingConfig, start_ns: int) -> None:
        self._config = config
        self._max_skew_ns = config.max_skew_ms * NS_PER_MS
        self._tracks = [_Track(name, start_ns) for name in names]
        self._last_ns: int | None = None

    def feed(self, camera: int, frame: Frame) -> Views | None:
        """Take a frame of one camera; the views of a new common instant, if it completes one."""
        self._tracks[camera].add(frame)
        if not all(track.frames for track in self._tracks) or self._frozen() or self._skew_ns() > self._max_skew_ns:
            return None
        views = self._views()
        if views is None or (self._last_ns is not None and views.t_ns - self._last_ns < self._least_step_ns(views)):
            return None
        self._last_ns = views.t_ns
        return views

    def problem(self, now_ns: int) -> str | None:
        """Say why no views come, in a sentence; None when all is well."""
        for track in self._tracks:
            silent_s = (now_ns - track.newest_ns) / NS_PER_S
            if silent_s * 1e3 > self._config.stale_ms:
                return f"camera {track.name} gives no frames for {silent_s:.1f} s"
        frozen = self._frozen()
        if frozen is not None:
            return f"camera {frozen.name} gave {frozen.repeats + 1} identical frames: frozen"
        if self._skew_ns() > self._max_skew_ns:
            behind = min(self._tracks, key=lambda track: track.newest_ns)
            return f"camera {behind.name} is {self._skew_ns() / NS_PER_MS:.0f} ms behind the others"
        slowest, wait_ms = max(self._tracks, key=lambda track: track.interval_ns), self._config.longest_wait_ms
        if slowest.interval_ns > SLOW * wait_ms * NS_PER_MS:
            return (
                f"camera {slowest.name} gives a picture only each {slowest.interval_ns / NS_PER_MS:.0f} ms, the limit "
                f"is {wait_ms:.0f} ms: let it give {2e3 / wait_ms:.0f} a second or more (fps and a fixed exposure_ms "
                "in [operator.cameras]), or set a longer capture.longest_wait_ms here and safety.t_soft_ms at the "
                "remote site"
            )
        return None

    def _views(self) -> Views | None:
        newest = [track.newest_ns for track in self._tracks]
        if max(newest) - min(newest) <= self._config.tolerance_ms * NS_PER_MS:
            return Views(sum(newest) // len(newest), tuple(View(track.frames[-1]) for track in self._tracks))
        t_ns = min(newest)
        views = [track.at(t_ns) for track in self._tracks]
        enclosed = tuple(view for view in views if view is not None)
        return Views(t_ns, enclosed) if len(enclosed) == len(views) else None

    def _least_step_ns(self, views: Views) -> float:
        """The least step to the next instant: a few ms after the last nothing new shows, at the cost of a pair."""
        gaps = [v.current.capture_ns - v.previous.capture_ns for v in views.views if v.previous is not None]
        return max(1.0, LEAST_STEP * min(gaps)) if gaps else 1.0

    def _skew_ns(self) -> int:
        newest = [track.newest_ns for track in self._tracks]
        return max(newest) - min(newest)

    def _frozen(self) -> "_Track | None":
        return next((track for track in self._tracks if track.repeats >= self._config.frozen_frames), None)


class _Track:
    """The last frames of one camera."""

    def __init__(self, name: str, start_ns: int) -> None:
        self.name = name
        self.frames: deque[Frame] = deque(maxlen=HISTORY)
        self.repeats = 0
        self._start_ns = start_ns

    @property
    def newest_ns(self) -> int:
        """The newest exposure, or the start while there is none."""
        return self.frames[-1].capture_ns if self.frames else self._start_ns

    @property
    def interval_ns(self) -> int:
        """The shortest time between the last exposures, as a single frame may be lost; 0 before there are enough."""
        if len(self.frames) < HISTORY:
            return 0
        return min(after.capture_ns - before.capture_ns for before, after in pairwise(self.frames))

    def add(self, frame: Frame) -> None:
        """Append a frame unless it is no newer than the last."""
        if self.frames:
            last = self.frames[-1]
            if frame.capture_ns <= last.capture_ns:
                return
            self.repeats = self.repeats + 1 if np.array_equal(frame.image, last.image) else 0
        self.frames.append(frame)

    def at(self, t_ns: int) -> View | None:
        """The view of an instant, None when no two exposures enclose it."""
        for previous, current in zip(self.frames, list(self.frames)[1:], strict=False):
            if previous.capture_ns < t_ns < current.capture_ns:
                weight = (t_ns - previous.capture_ns) / (current.capture_ns - previous.capture_ns)
                return View(current, previous, weight)
        return next((View(frame) for frame in self.frames if frame.capture_ns == t_ns), None)

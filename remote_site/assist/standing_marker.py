"""A marker that stands still, and where: judged by what was seen of it over the last moments; pure."""

import math
from collections import deque

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array, rotation_from_vector, transform, vector_from_rotation
from remote_site.assist.leading import left_over
from remote_site.assist.sighting import MarkerSighting
from remote_site.reasons import Code, Reason, reason

STEADY_NS, KEPT_NS = 300 * NS_PER_MS, 1000 * NS_PER_MS
LEAST = 3  # sightings of a marker that stands still
FRESH_NS = 700 * NS_PER_MS  # of the oldest exposure in the newest sighting
MISSED_NS = 500 * NS_PER_MS  # a marker that one round of pictures misses is not covered
MOVED_M, MOVED_RAD = 0.004, math.radians(3.0)


class StandingMarker:
    """The sightings of one marker in a row that agree; one elsewhere begins again."""

    def __init__(self, marker: int) -> None:
        self._marker = marker
        self._seen: deque[MarkerSighting] = deque()
        self._refusal: Reason | None = reason(Code.MARKER_UNSEEN, marker=marker)
        self._moved: Reason | None = None

    def see(self, sighting: MarkerSighting) -> None:
        """Take the newest sighting."""
        self._refusal = sighting.refusal
        if sighting.base_T_marker is None:
            return
        self._moved = self._shift(sighting.base_T_marker)
        if self._moved is not None:
            self._seen.clear()
        self._seen.append(sighting)
        while sighting.t_ns - self._seen[0].t_ns > KEPT_NS:
            self._seen.popleft()

    def pose(self, now_ns: int) -> tuple[Array, tuple[str, ...]] | Reason:
        """Return where it stands (4 x 4) with the views that see it, or why that is not known."""
        lost = self._lost(now_ns)
        if lost is not None:
            return lost
        if len(self._seen) < LEAST or self._seen[-1].t_ns - self._seen[0].t_ns < STEADY_NS:
            return self._moved or reason(Code.ASSIST_STEADYING, marker=self._marker, least_ms=STEADY_NS / NS_PER_MS)
        return self._mean(), self._seen[-1].views

    def strayed(self, base_T_marker: Array, now_ns: int) -> Reason | None:
        """Say why one cannot rely any more on the marker being still there (4 x 4); None if one can."""
        lost = self._lost(now_ns)
        if lost is not None:
            return lost
        newest = self._seen[-1].base_T_marker
        distance_m, angle_rad = left_over(base_T_marker, newest) if newest is not None else (0.0, 0.0)
        return self._moved_by(distance_m, angle_rad)

    def _lost(self, now_ns: int) -> Reason | None:
        """Say why the newest sighting does not count: it is too old, or what came since tells otherwise."""
        age_ns = now_ns - self._seen[-1].t_ns if self._seen else now_ns
        if self._refusal is not None and (age_ns > MISSED_NS or self._refusal.code is Code.MARKER_DOUBLED):
            return self._refusal
        if age_ns > FRESH_NS:
            return reason(Code.MARKER_STALE, marker=self._marker, age_ms=age_ns / NS_PER_MS)
        return None

    def _shift(self, base_T_marker: Array) -> Reason | None:
        """Say how far it is from where it stood, if that is too far."""
        return self._moved_by(*left_over(self._mean(), base_T_marker)) if self._seen else self._moved

    def _moved_by(self, distance_m: float, angle_rad: float) -> Reason | None:
        if distance_m <= MOVED_M and angle_rad <= MOVED_RAD:
            return None
        moved = {"distance_mm": 1e3 * distance_m, "angle_deg": math.degrees(angle_rad)}
        return reason(Code.MARKER_MOVED, marker=self._marker, **moved)

    def _mean(self) -> Array:
        """The mean of the poses: of positions, and of rotations from the first."""
        poses = [s.base_T_marker for s in self._seen if s.base_T_marker is not None]
        first = poses[0][:3, :3]
        turn = np.mean([vector_from_rotation(pose[:3, :3] @ first.T) for pose in poses], axis=0)
        return transform(rotation_from_vector(turn) @ first, np.mean([pose[:3, 3] for pose in poses], axis=0))

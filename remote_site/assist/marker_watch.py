"""Keeps what each view has seen of the markers, and judges whether their poses are to be believed; pure."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array, inverse
from common.messages.requests import ViewCalibration
from remote_site.assist.config import AssistConfig
from remote_site.assist.detection import FoundMarkers
from remote_site.assist.marker_pose import MarkerPose, MarkerView, fit_marker
from remote_site.assist.sighting import MarkerSighting
from remote_site.reasons import Code, Reason, reason

FRESH_NS = 450 * NS_PER_MS  # a busy host takes two or three pictures a second of each view
NEAR_M = 0.25  # one view alone, of a camera on the tool, suffices within this distance
GRAZING_RAD = math.radians(70.0)
MOST_MISS_PX = 1.5
MOST_SIGMA_M, MOST_SIGMA_RAD = 0.002, math.radians(1.0)


class _Looked(NamedTuple):
    """A marker in one picture: when it was exposed, the camera's projection then, each place (4, 2) of the marker."""

    t_ns: int
    projection: Array
    places: Sequence[Array]


class _Refusal(Exception):  # noqa: N818  # a verdict, never seen outside this file
    """A marker's pose is not to be believed."""

    def __init__(self, why: Reason) -> None:
        super().__init__(why.sentence)
        self.why = why


class MarkerWatch:
    """The newest picture of each calibrated view, and what they show of the markers together."""

    def __init__(self, config: AssistConfig, views: Mapping[str, ViewCalibration]) -> None:
        self._sizes = config.marker_sizes_m
        self._levers = {m: [t.marker_T_tool[:3, 3] for t in config.targets if t.marker == m] for m in self._sizes}
        self._views = views
        self._newest: dict[str, dict[int, _Looked]] = {view: {} for view in views}
        self._unreached: dict[str, tuple[int, Collection[int]]] = {}

    def observe(self, view: str, t_ns: int, found: FoundMarkers, base_T_tool: Array | None) -> None:
        """Take what a view's picture of the time `t_ns` shows; a camera on the tool needs the tool's pose (4 x 4) then.

        Views without calibration are ignored.
        """
        if view not in self._views:
            return
        calibration = self._views[view]
        projection = np.reshape(calibration.projection, (3, 4))
        if calibration.on_tool:
            if base_T_tool is None:
                return
            projection = projection @ inverse(base_T_tool)
        self._unreached[view] = t_ns, found.unreached
        reached = (marker for marker in self._sizes if marker not in found.unreached)
        self._newest[view] |= {m: _Looked(t_ns, projection, found.corners.get(m, ())) for m in reached}

    def sightings(self, now_ns: int) -> list[MarkerSighting]:
        """Return what is known of each marker now, in the order of the targets that name them."""
        return [self._sighting(marker, now_ns) for marker in self._sizes]

    def _sighting(self, marker: int, now_ns: int) -> MarkerSighting:
        try:
            views, t_ns = self._seen(marker, now_ns)
            pose, views = self._pose(marker, views)
        except _Refusal as refusal:
            return MarkerSighting(marker, now_ns, None, refusal.why)
        return MarkerSighting(marker, t_ns, pose.base_T_marker, None, tuple(view.name for view in views))

    def _seen(self, marker: int, now_ns: int) -> tuple[list[MarkerView], int]:
        """The views that see the marker in pictures that are fresh, and the oldest exposure of these."""
        known = {name: seen[marker] for name, seen in self._newest.items() if marker in seen}
        fresh = {name: one for name, one in known.items() if now_ns - one.t_ns <= FRESH_NS}
        for name, (t_ns, numbers) in self._unreached.items():
            if marker in numbers and name not in fresh and now_ns - t_ns <= FRESH_NS:
                raise _Refusal(reason(Code.MARKER_CROWDED, marker=marker, view=name))
        if not fresh:
            newest_ns = max((one.t_ns for one in known.values()), default=0)
            raise _Refusal(reason(Code.MARKER_STALE, marker=marker, age_ms=(now_ns - newest_ns) / NS_PER_MS))
        for name, one in fresh.items():
            if len(one.places) > 1:
                raise _Refusal(reason(Code.MARKER_DOUBLED, marker=marker, view=name))
        views, times = [], []
        for name, one in fresh.items():
            if one.places:
                views.append(MarkerView(name, one.projection, one.places[0]))
                times.append(one.t_ns)
        if not views:
            raise _Refusal(reason(Code.MARKER_UNSEEN, marker=marker))
        return views, min(times)

    def _pose(self, marker: int, views: list[MarkerView]) -> tuple[MarkerPose, list[MarkerView]]:
        """The pose in all views that do not graze the marker, which may be fewer than those that see it."""
        if len(views) == 1 and not self._views[views[0].name].on_tool:
            raise _Refusal(reason(Code.MARKER_ONE_VIEW, marker=marker, view=views[0].name))
        pose = self._fitted(marker, views)
        facing = [view for view in views if pose.incidence_rad(view) <= GRAZING_RAD]
        if len(facing) < len(views):
            if len(facing) < 2 and not any(self._views[view.name].on_tool for view in facing):
                worst = max(pose.incidence_rad(view) for view in views)
                limit_deg = math.degrees(GRAZING_RAD)
                raise _Refusal(
                    reason(Code.MARKER_GRAZING, marker=marker, angle_deg=math.degrees(worst), limit_deg=limit_deg)
                )
            pose = self._fitted(marker, facing)
        self._check(marker, pose, facing)
        return pose, facing

    def _fitted(self, marker: int, views: list[MarkerView]) -> MarkerPose:
        pose = fit_marker(views, self._sizes[marker])
        if pose is None:
            raise _Refusal(reason(Code.MARKER_CONTRADICTED, marker=marker, views=_names(views), miss_px=math.inf))
        return pose

    def _check(self, marker: int, pose: MarkerPose, views: list[MarkerView]) -> None:
        if pose.rms_px > MOST_MISS_PX:
            names = _names(views)
            raise _Refusal(reason(Code.MARKER_CONTRADICTED, marker=marker, views=names, miss_px=pose.rms_px))
        if len(views) == 1:
            distance_m = math.dist(views[0].centre.tolist(), pose.base_T_marker[:3, 3].tolist())
            if distance_m > NEAR_M:
                far = {"distance_mm": 1e3 * distance_m, "limit_mm": 1e3 * NEAR_M}
                raise _Refusal(reason(Code.MARKER_FAR, marker=marker, view=views[0].name, **far))
        if pose.ambiguous:
            raise _Refusal(reason(Code.MARKER_AMBIGUOUS, marker=marker, views=_names(views)))
        sigma_m, sigma_rad = np.max([pose.sigma_at(lever) for lever in self._levers[marker]], axis=0)
        if sigma_m > MOST_SIGMA_M or sigma_rad > MOST_SIGMA_RAD:
            known = {"sigma_mm": 1e3 * sigma_m, "sigma_deg": math.degrees(sigma_rad)}
            raise _Refusal(reason(Code.MARKER_UNCERTAIN, marker=marker, **known))


def _names(views: list[MarkerView]) -> str:
    return " and ".join(view.name for view in views)

"""Farhand's own trackers, as the entry points in pyproject.toml name them."""

from typing import TypeVar

import msgspec

from local_site.tracking.config import EyeConfig, LearnedConfig, MarkersConfig, MonocularConfig, SilhouetteConfig
from local_site.tracking.eye.eye_tracker import EyeTracker
from local_site.tracking.learned.learned_tracker import LearnedTracker
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.registry import TrackerHost, TrackerKind
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker

S = TypeVar("S", bound=msgspec.Struct)


def _own(host: TrackerHost, kind: type[S]) -> S:
    """The tracker's own table."""
    return host.own if isinstance(host.own, kind) else kind()


silhouette = TrackerKind(
    lambda host: SilhouetteTracker(host.rig, _own(host, SilhouetteConfig), host.profile),
    "a bare arm before a dark, plain background",
)
learned = TrackerKind(
    lambda host: LearnedTracker(host.rig, _own(host, LearnedConfig), host.profile),
    "a bare arm in any room; needs the models: farhand models install",
    "room",
)
eye = TrackerKind(
    lambda host: EyeTracker(host.rig, _own(host, EyeConfig)),
    "a bare arm in any room, by networks of Farhand's own; it tells no open hand yet",
    "room",
)
markers = TrackerKind(
    lambda host: MarkerTracker(host.rig, _own(host, MarkersConfig)), "three bright markers on a dark glove", "markers"
)
monocular = TrackerKind(
    lambda host: MonocularTracker(host.rig, _own(host, MonocularConfig)), "a bare arm before one camera", "textured"
)

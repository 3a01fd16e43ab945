"""Which tracker a site runs: the choice, the parameters of each, and how one is made."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from local_site.calibration.rig import Rig
from local_site.tracking.config import LearnedConfig, MarkersConfig, Method, MonocularConfig, SilhouetteConfig
from local_site.tracking.learned.learned_tracker import LearnedTracker
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import Tracker


class TrackingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the operator's arm is tracked."""

    method: Annotated[
        Method,
        Meta(
            description="silhouette: a bare arm before a dark wall; learned: one in an ordinary room, in colour; "
            "markers: three bright markers on a dark glove; monocular: one camera"
        ),
    ] = "silhouette"
    silhouette: SilhouetteConfig = field(default_factory=SilhouetteConfig)
    learned: LearnedConfig = field(default_factory=LearnedConfig)
    markers: MarkersConfig = field(default_factory=MarkersConfig)
    monocular: MonocularConfig = field(default_factory=MonocularConfig)
    profile_dir: Annotated[
        str, Meta(description="folder with what is learned of each operator's body, by name; empty: nothing is kept")
    ] = ""


def make_tracker(rig: Rig, config: TrackingConfig, profile: OperatorProfile | None = None) -> Tracker:
    """The tracker that the configuration asks for, with the operator's profile, if there is one."""
    if config.method == "markers":
        return MarkerTracker(rig, config.markers)
    if config.method == "monocular":
        return MonocularTracker(rig, config.monocular)
    if config.method == "learned":
        return LearnedTracker(rig, config.learned, profile)
    return SilhouetteTracker(rig, config.silhouette, profile)


def profile_of(tracker: Tracker) -> OperatorProfile | None:
    """The operator's profile as a tracker has learned it; None for trackers that learn none."""
    return tracker.profile if isinstance(tracker, SilhouetteTracker | LearnedTracker) else None

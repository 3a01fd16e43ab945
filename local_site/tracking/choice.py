"""Which tracker a site runs: the choice, the parameters of each, and how one is made."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from local_site.calibration.rig import Rig
from local_site.tracking.markers.config import MarkersConfig
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.method import Method
from local_site.tracking.silhouette.config import SilhouetteConfig
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import Tracker


class TrackingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the operator's arm is tracked."""

    method: Annotated[
        Method, Meta(description="silhouette: a bare arm; markers: three bright markers on a dark glove")
    ] = "silhouette"
    silhouette: SilhouetteConfig = field(default_factory=SilhouetteConfig)
    markers: MarkersConfig = field(default_factory=MarkersConfig)


def make_tracker(rig: Rig, config: TrackingConfig) -> Tracker:
    """The tracker that the configuration asks for."""
    if config.method == "markers":
        return MarkerTracker(rig, config.markers)
    return SilhouetteTracker(rig, config.silhouette)

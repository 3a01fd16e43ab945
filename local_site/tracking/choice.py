"""Choice of a site's tracker, the parameters of Farhand's own trackers, and how one is made."""

from typing import Annotated

import msgspec
from msgspec import Meta, field

from common.text import instead_of
from local_site.calibration.rig import Rig
from local_site.tracking.config import EyeConfig, LearnedConfig, MarkersConfig, MonocularConfig, SilhouetteConfig
from local_site.tracking.registry import Option, TrackerHost, tracker_kind, tracker_names
from local_site.tracking.silhouette.operator_profile import OperatorProfile
from local_site.tracking.tracker import Tracker


class TrackingConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How the operator's arm is tracked."""

    method: Annotated[
        str,
        Meta(
            description="silhouette: a bare arm before a dark wall; learned: one in an ordinary room, in colour; "
            "eye: the same by networks of Farhand's own, no open hand is told; markers: three bright markers on a dark "
            "glove; monocular: one camera; or an installed tracker"
        ),
    ] = "silhouette"
    silhouette: SilhouetteConfig = field(default_factory=SilhouetteConfig)
    learned: LearnedConfig = field(default_factory=LearnedConfig)
    eye: EyeConfig = field(default_factory=EyeConfig)
    markers: MarkersConfig = field(default_factory=MarkersConfig)
    monocular: MonocularConfig = field(default_factory=MonocularConfig)
    options: Annotated[dict[str, Option], Meta(description="the options of an installed tracker, by its own keys")] = (
        field(default_factory=dict)
    )
    profile_dir: Annotated[
        str, Meta(description="folder with what is learned of each operator's body, by name; empty: nothing is kept")
    ] = ""

    def __post_init__(self) -> None:
        if self.method not in tracker_names():
            raise ValueError(f"method {self.method!r} is not allowed: {instead_of(self.method, tracker_names())}")
        if self.options and self.own is not None:
            raise ValueError(f"options are for an installed tracker: set {self.method}'s in tracking.{self.method}")

    @property
    def own(self) -> msgspec.Struct | None:
        """The table of the method's name, which each of Farhand's own trackers has."""
        table = getattr(self, self.method, None)
        return table if isinstance(table, msgspec.Struct) else None


def make_tracker(rig: Rig, config: TrackingConfig, profile: OperatorProfile | None = None) -> Tracker:
    """The tracker that the configuration asks for, with the operator's profile, if there is one."""
    return tracker_kind(config.method).make(TrackerHost(rig, config.options, config.own, profile))


def profile_of(tracker: Tracker) -> OperatorProfile | None:
    """The operator's profile as a tracker has learned it; None for trackers that learn none."""
    profile = getattr(tracker, "profile", None)
    return profile if isinstance(profile, OperatorProfile) else None

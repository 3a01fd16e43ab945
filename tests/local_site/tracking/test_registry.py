"""A tracker of another package: found by its entry point, given its options, listed, refused where it cannot be."""

from importlib.metadata import EntryPoint

import msgspec
import numpy as np
import pytest

from common.config.loading import load_config
from common.errors import ConfigError
from common.messages.hand import TrackingStatus
from farhand.tracking.listing import installed_trackers
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import StereoConfig
from local_site.tracking import registry
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.registry import GROUP, TrackerHost, TrackerKind, check_options
from local_site.tracking.tracker import ArmEstimate, Views
from tests.present import present

RIG = exact_rig(StereoConfig())


class StillOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    x_m: float = 0.5


class StillTracker:
    def __init__(self, host: TrackerHost) -> None:
        self._wrist = np.array([check_options(StillOptions, host.options).x_m, 0.0, 0.0])

    def track(self, views: Views) -> ArmEstimate:
        return ArmEstimate(views.t_ns, TrackingStatus.TRACKED, "", wrist=self._wrist)


STILL, NO_KIND = TrackerKind(StillTracker, "a hand that stays"), "nothing"


@pytest.fixture(autouse=True)
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    points = dict(registry._installed())
    for name, value in {"still": "STILL", "none": "NO_KIND", "gone": "MISSING"}.items():
        points[name] = EntryPoint(name, f"{__name__}:{value}", GROUP)
    monkeypatch.setattr(registry, "_installed", lambda: points)


def test_a_tracker_of_another_package_is_made_with_its_options() -> None:
    config = load_config(TrackingConfig, None, ["method=still", "options.x_m=0.25"])
    estimate = make_tracker(RIG, config).track(Views(7, ()))
    assert (estimate.t_ns, present(estimate.wrist).tolist()) == (7, [0.25, 0.0, 0.0])


def test_a_wrong_option_is_named() -> None:
    config = load_config(TrackingConfig, None, ["method=still", "options.x_mm=250"])
    with pytest.raises(ConfigError, match=r"tracking\.options\.x_mm: is not a key here; did you mean x_m\?"):
        make_tracker(RIG, config)


def test_a_tracker_of_farhands_own_takes_no_options() -> None:
    with pytest.raises(ConfigError, match=r"an installed tracker: set markers's in tracking\.markers"):
        load_config(TrackingConfig, None, ["method=markers", "options.x_m=0.25"])


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("none", "is no TrackerKind, but str"), ("gone", "cannot be loaded"), ("ultrasound", "choose one of: .*markers")],
)
def test_what_cannot_be_used_is_named(name: str, wrong: str) -> None:
    with pytest.raises(ConfigError, match=wrong):
        registry.tracker_kind(name)


def test_all_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    points = list(registry._installed().values())
    monkeypatch.setattr("farhand.tracking.listing.entry_points", lambda **_: points)
    listed = {tracker.name: tracker for tracker in installed_trackers()}
    assert set(listed) >= {"silhouette", "learned", "markers", "monocular", "still", "none", "gone"}
    assert listed["silhouette"].tracks == "a bare arm before a dark, plain background"
    assert listed["still"].origin == "of an unknown package"
    assert str(listed["gone"]).startswith("gone (of an unknown package): CANNOT BE USED: the tracker 'gone'")

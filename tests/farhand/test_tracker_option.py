"""The --tracker option: which tracker runs, and what the simulated operator wears for it."""

import pytest

from common.config import load_config
from common.errors import ConfigError
from farhand.loopback import LoopbackOptions, plan_of
from local_site.calibration.simulated import calibrate_simulated
from local_site.config import LocalConfig
from local_site.simulation.config import SimulationConfig
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.markers.marker_tracker import MarkerTracker
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker


@pytest.mark.parametrize(("name", "kind"), [("silhouette", SilhouetteTracker), ("markers", MarkerTracker)])
def test_the_loopback_runs_the_tracker_that_is_asked_for_before_an_operator_dressed_for_it(name, kind):
    local = load_config(LocalConfig, None, plan_of(LoopbackOptions(tracker=name)).local)
    assert isinstance(make_tracker(calibrate_simulated(SimulationConfig()), local.tracking), kind)
    assert local.simulation.markers == (name == "markers")


def test_an_unknown_tracker_is_refused_before_anything_starts():
    with pytest.raises(ConfigError, match=r"tracking\.method"):
        plan_of(LoopbackOptions(tracker="ultrasound"))


def test_each_tracker_has_a_table_of_its_own():
    settings = ("method=markers", "markers.initial_pairs=3", "silhouette.initial_pairs=20")
    config = load_config(TrackingConfig, None, settings)
    assert (config.markers.initial_pairs, config.silhouette.initial_pairs) == (3, 20)

"""Warming up leaves nothing to be compiled while an arm is tracked."""

import pkgutil
import sys
from importlib import import_module

import pytest
from numba.core.registry import CPUDispatcher

from common.cameras.camera import Frame
from common.errors import NotInstalledError
from common.messages.hand import TrackingStatus
from local_site.runtime.warm_up import warm_up
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from local_site.tracking import foreground, learned, silhouette
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import View, Views


def compiled(*packages):
    """How many signatures each compiled function has."""
    for package in packages:
        for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
            import_module(module.name)
    functions = {
        f"{name}.{key}": len(value.signatures)
        for name, module in list(sys.modules.items())
        if name.startswith(tuple(package.__name__ for package in packages))
        for key, value in vars(module).items()
        if isinstance(value, CPUDispatcher)
    }
    assert functions
    return functions


def track(simulation, tracking, instants):
    """Track a simulated operator; what came of it."""
    operator = SimulatedOperator(simulation)
    tracker = make_tracker(exact_rig(simulation.stereo), tracking)
    estimates = []
    for k in instants:
        frames = [Frame(image, k * 33_000_000, k) for image in operator.render(k / 30)]
        estimates.append(tracker.track(Views(k * 33_000_000, tuple(View(frame) for frame in frames))))
    return estimates


def test_nothing_is_left_to_compile():
    warm_up(TrackingConfig())
    before = compiled(silhouette)
    track(SimulationConfig(motion=MotionConfig(name="toggles")), TrackingConfig(), range(0, 90, 3))
    assert compiled(silhouette) == before


@pytest.mark.slow
def test_nothing_is_left_to_compile_in_a_room():
    tracking = TrackingConfig(method="learned")
    try:
        warm_up(tracking)
    except NotInstalledError as missing:
        pytest.skip(str(missing))
    before = compiled(silhouette, foreground, learned)
    room = RoomConfig(scene="office", empty_s=0.5)
    simulation = SimulationConfig(room=room, motion=MotionConfig(name="toggles", still_s=1.0))
    estimates = track(simulation, tracking, range(100))
    assert TrackingStatus.TRACKED in [estimate.status for estimate in estimates]
    assert compiled(silhouette, foreground, learned) == before

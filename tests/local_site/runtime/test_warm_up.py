"""Warming up leaves nothing to be compiled while an arm is tracked."""

import pkgutil
import sys
from importlib import import_module

from numba.core.registry import CPUDispatcher

from common.cameras.camera import Frame
from local_site.runtime.warm_up import warm_up
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import MotionConfig, SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking import silhouette
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.tracker import View, Views


def compiled():
    """How many signatures each compiled function has."""
    for module in pkgutil.walk_packages(silhouette.__path__, silhouette.__name__ + "."):
        import_module(module.name)
    functions = {
        f"{name}.{key}": len(value.signatures)
        for name, module in list(sys.modules.items())
        if name.startswith(silhouette.__name__)
        for key, value in vars(module).items()
        if isinstance(value, CPUDispatcher)
    }
    assert functions
    return functions


def test_nothing_is_left_to_compile():
    warm_up(TrackingConfig())
    before = compiled()
    simulation = SimulationConfig(motion=MotionConfig(name="toggles"))
    operator = SimulatedOperator(simulation)
    tracker = make_tracker(exact_rig(simulation.stereo), TrackingConfig())
    for k in range(0, 90, 3):
        frames = [Frame(image, k * 33_000_000, k) for image in operator.render(k / 30)]
        tracker.track(Views(k * 33_000_000, tuple(View(frame) for frame in frames)))
    assert compiled() == before

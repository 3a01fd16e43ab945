"""Tracks a simulated arm for an instant before the real one: inner loops are compiled when they first run.

That takes up to a minute once for an installation, and half a second after that; no watchdog and no first pair of
frames should have to wait for it.
"""

from itertools import cycle, islice

import msgspec

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.silhouette.config import SilhouetteConfig
from local_site.tracking.tracker import View, Views

INSTANTS = 3
PERIOD_NS = NS_PER_S // 30


def warm_up(tracking: TrackingConfig, cameras: int) -> None:
    """Run the tracker with every number of views that it may have to do with; markers need no compiling."""
    if tracking.method == "markers":
        return
    simulation = SimulationConfig()
    operator, pair = SimulatedOperator(simulation), exact_rig(simulation.stereo)
    instants = [_frames(operator, k) for k in range(INSTANTS)]
    for count in range(2, cameras + 1):
        rig = msgspec.structs.replace(pair, cameras=tuple(islice(cycle(pair.cameras), count)))
        tracker = make_tracker(rig, TrackingConfig(silhouette=SilhouetteConfig(initial_pairs=1)))
        for frames in instants:
            views = tuple(View(frame) for frame in islice(cycle(frames), count))
            tracker.track(Views(frames[0].capture_ns, views))


def _frames(operator: SimulatedOperator, k: int) -> list[Frame]:
    """What both cameras see at the instant of this number."""
    t_ns = k * PERIOD_NS
    return [Frame(image, t_ns, k) for image in operator.render(t_ns / NS_PER_S)]

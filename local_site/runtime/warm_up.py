"""Tracks a simulated arm for an instant before the real one: inner loops are compiled when they first run.

That takes up to a minute once for an installation, and half a second after that; no watchdog and no first pair of
frames should have to wait for it.
"""

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hazel import film_camera
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.textured_operator import TexturedOperator, first_joints_px
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.config import MonocularConfig, SilhouetteConfig, StartBy, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import View, Views

INSTANTS = 3
PERIOD_NS = NS_PER_S // 30
SWING_S = 0.6  # so long that the arm turns and the tracker learns more of it


def warm_up(tracking: TrackingConfig) -> None:
    """Track a few instants; markers need no compiling."""
    if tracking.method == "markers":
        return
    if tracking.method == "monocular":
        _warm_up_monocular(tracking.monocular.start.by)
        return
    simulation = SimulationConfig()
    operator = SimulatedOperator(simulation)
    tracker = make_tracker(exact_rig(simulation.stereo), TrackingConfig(silhouette=SilhouetteConfig(initial_pairs=1)))
    for k in range(INSTANTS):
        views = tuple(View(frame) for frame in _frames(operator, k))
        tracker.track(Views(k * PERIOD_NS, views))


def _warm_up_monocular(by: StartBy) -> None:
    """An arm that swings before one camera, started as it will be: each way has inner loops of its own."""
    operator = TexturedOperator(still_s=0.0)
    shoulder, elbow, wrist = first_joints_px().values()
    start = StartConfig(by=by, shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    tracker = MonocularTracker(film_camera(), MonocularConfig(start=start))
    for k in range(INSTANTS):
        (image,) = operator.render(SWING_S * k)
        tracker.track(Views(k * PERIOD_NS, (View(Frame(image, k * PERIOD_NS, k)),)))


def _frames(operator: SimulatedOperator, k: int) -> list[Frame]:
    """What both cameras see at the instant of this number."""
    t_ns = k * PERIOD_NS
    return [Frame(image, t_ns, k) for image in operator.render(t_ns / NS_PER_S)]


if __name__ == "__main__":
    warm_up(TrackingConfig())

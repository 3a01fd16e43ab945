"""Tracks a simulated arm for an instant before the real one: inner loops are compiled when they first run.

That takes up to a minute once for an installation, and half a second after that; no watchdog and no first pair of
frames should have to wait for it.
"""

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hazel import Swing, film_camera, film_pixel, hazel_film
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.monocular.config import MonocularConfig, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.silhouette.config import SilhouetteConfig
from local_site.tracking.tracker import View, Views

INSTANTS = 3
PERIOD_NS = NS_PER_S // 30


def warm_up(tracking: TrackingConfig) -> None:
    """Track a few instants; markers need no compiling."""
    if tracking.method == "markers":
        return
    if tracking.method == "monocular":
        _warm_up_monocular()
        return
    simulation = SimulationConfig()
    operator = SimulatedOperator(simulation)
    tracker = make_tracker(exact_rig(simulation.stereo), TrackingConfig(silhouette=SilhouetteConfig(initial_pairs=1)))
    for k in range(INSTANTS):
        views = tuple(View(frame) for frame in _frames(operator, k))
        tracker.track(Views(k * PERIOD_NS, views))


def _warm_up_monocular() -> None:
    """An arm that swings before one camera; its joints lie where the film has them at first."""
    camera, film = film_camera(), hazel_film()
    first = Swing().arm(0)
    shoulder, elbow, wrist = (film_pixel(point) for point in (first.shoulder, first.elbow, first.wrist))
    start = StartConfig(shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    tracker = MonocularTracker(camera, MonocularConfig(start=start))
    for k in range(INSTANTS):
        frame = Frame(film.render(Swing(speed=20.0).arm(k).places()), k * PERIOD_NS, k)
        tracker.track(Views(k * PERIOD_NS, (View(frame),)))


def _frames(operator: SimulatedOperator, k: int) -> list[Frame]:
    """What both cameras see at the instant of this number."""
    t_ns = k * PERIOD_NS
    return [Frame(image, t_ns, k) for image in operator.render(t_ns / NS_PER_S)]


if __name__ == "__main__":
    warm_up(TrackingConfig())

"""Tracks a simulated arm for an instant before the real one: inner loops are compiled when they first run.

That takes up to a minute once for an installation, and half a second after that; no watchdog and no first pair of
frames should have to wait for it.
"""

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from local_site.calibration.rig import Rig
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.hazel import TexturedOperator, film_camera, first_joints_px
from local_site.simulation.operator import Operator, SimulatedOperator
from local_site.tracking.choice import TrackingConfig, make_tracker
from local_site.tracking.config import MonocularConfig, SilhouetteConfig, StartBy, StartConfig
from local_site.tracking.monocular.monocular_tracker import MonocularTracker
from local_site.tracking.tracker import Tracker, View, Views

INSTANTS = 3
PERIOD_NS = NS_PER_S // 30
SWING_S = 0.6  # long enough that the arm turns and the tracker learns more of it


def warm_up(tracking: TrackingConfig) -> None:
    """Track a few instants; markers need no compiling."""
    if tracking.method == "markers":
        return
    if tracking.method == "monocular":
        operator: Operator = TexturedOperator(still_s=0.0)
        rig, step_s = film_camera(), SWING_S
        tracker = _monocular(rig, tracking.monocular.start.by)
    else:
        simulation = SimulationConfig()
        operator = SimulatedOperator(simulation)
        rig, step_s = exact_rig(simulation.stereo), PERIOD_NS / NS_PER_S
        tracker = make_tracker(rig, TrackingConfig(silhouette=SilhouetteConfig(initial_pairs=1)))
    cameras = tuple(range(len(rig.cameras)))
    for k in range(INSTANTS):
        t_ns = k * PERIOD_NS
        views = tuple(View(Frame(image, t_ns, k)) for image in operator.render(k * step_s, cameras))
        tracker.track(Views(t_ns, views))


def _monocular(rig: Rig, by: StartBy) -> Tracker:
    """A tracker of the swinging arm, started as configured: each start method has inner loops of its own."""
    shoulder, elbow, wrist = first_joints_px().values()
    start = StartConfig(by=by, shoulder_px=shoulder, elbow_px=elbow, wrist_px=wrist)
    return MonocularTracker(rig, MonocularConfig(start=start))


if __name__ == "__main__":
    warm_up(TrackingConfig())

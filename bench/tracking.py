"""What tracking a stereo pair costs, over the simulated operator's pick and place, on one core."""

import statistics
import time

import cv2

from common.cameras.camera import Frame
from common.clock import NS_PER_S
from local_site.simulation.cameras import exact_rig
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.silhouette.silhouette_tracker import SilhouetteTracker
from local_site.tracking.tracker import View, Views

PAIRS = 400
FPS = 30.0


def measure() -> dict[str, float]:
    """Median and 95th percentile in ms per pair, after the initialisation."""
    cv2.setNumThreads(1)
    config = SimulationConfig()
    operator, tracker = SimulatedOperator(config), SilhouetteTracker(exact_rig(config.stereo))
    times_ms = []
    for k in range(PAIRS):
        t_ns = round(k * NS_PER_S / FPS)
        views = Views(t_ns, tuple(View(Frame(image, t_ns, k)) for image in operator.render(k / FPS)))
        begin = time.perf_counter()
        tracker.track(views)
        times_ms.append(1e3 * (time.perf_counter() - begin))
    after = times_ms[20:]
    return {"median ms per pair": statistics.median(after), "p95 ms per pair": statistics.quantiles(after, n=20)[-1]}

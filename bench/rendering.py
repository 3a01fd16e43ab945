"""How long the simulated operator takes to draw a stereo pair: plain, and with noise, blur and distortion."""

import statistics
import time

import cv2

from local_site.simulation.config import PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator

PAIRS = 200
STEP_S = 0.08
CONFIGS = {
    "plain": SimulationConfig(picture=PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0)),
    "noise, blur, distortion": SimulationConfig(stereo=StereoConfig(k1=-0.1)),
    "and motion blur": SimulationConfig(stereo=StereoConfig(k1=-0.1), picture=PictureConfig(shutter_ms=15.0)),
}


def measure() -> dict[str, float]:
    """Median and 95th percentile in ms of every configuration, over the pick-and-place motion, on one core."""
    cv2.setNumThreads(1)
    figures: dict[str, float] = {}
    for name, config in CONFIGS.items():
        times_ms = _pair_times_ms(SimulatedOperator(config))
        figures[f"{name}, median ms"] = statistics.median(times_ms)
        figures[f"{name}, p95 ms"] = statistics.quantiles(times_ms, n=20)[-1]
    return figures


def _pair_times_ms(operator: SimulatedOperator) -> list[float]:
    times_ms = []
    for k in range(PAIRS):
        start = time.perf_counter()
        operator.render(k * STEP_S)
        times_ms.append(1e3 * (time.perf_counter() - start))
    return times_ms

"""How long the simulated operator takes to draw a stereo pair: plain, and with noise, blur and distortion."""

import statistics
import time

import cv2

from local_site.simulation.config import PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator

PAIRS = 200
STEP_S = 0.08
LIMITS_MS = {"plain": 5.0, "noise, blur, distortion": 12.0}
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


def main() -> None:
    """Print the table."""
    figures = measure()
    print(f"{'stereo pair, 640 x 480':28}{'median ms':>10}{'p95 ms':>10}{'limit ms':>10}")
    for name in CONFIGS:
        limit = LIMITS_MS.get(name)
        median, p95 = figures[f"{name}, median ms"], figures[f"{name}, p95 ms"]
        print(f"{name:28}{median:10.2f}{p95:10.2f}{'' if limit is None else limit:>10}")


if __name__ == "__main__":
    main()

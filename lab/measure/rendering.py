"""Times to draw the simulated operator's stereo pair and the cell's views, with their size as JPEG."""

import math
import statistics
import time

import cv2

from local_site.simulation.config import PictureConfig, SimulationConfig, StereoConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.simulation.room.config import RoomConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg

PAIRS = 200
STEP_S = 0.08
SWING_RAD = 0.2
CONFIGS = {
    "plain": SimulationConfig(picture=PictureConfig(blur_sigma_px=0.0, noise_sigma=0.0)),
    "noise, blur, distortion": SimulationConfig(stereo=StereoConfig(k1=-0.1)),
    "and motion blur": SimulationConfig(stereo=StereoConfig(k1=-0.1), picture=PictureConfig(shutter_ms=15.0)),
    "in an office": SimulationConfig(room=RoomConfig(scene="office")),
}


def measure() -> dict[str, float]:
    """Median and 95th percentile in ms of every configuration and view, on one core; kB of a view's pictures."""
    cv2.setNumThreads(1)
    return pairs() | cell_views()


def pairs() -> dict[str, float]:
    """The simulated operator's stereo pairs, over the pick-and-place motion."""
    figures: dict[str, float] = {}
    for name, config in CONFIGS.items():
        operator, times_ms = SimulatedOperator(config), []
        for k in range(PAIRS):
            start = time.perf_counter()
            operator.render(k * STEP_S)
            times_ms.append(1e3 * (time.perf_counter() - start))
        figures[f"{name}, median ms"] = statistics.median(times_ms)
        figures[f"{name}, p95 ms"] = statistics.quantiles(times_ms, n=20)[-1]
    return figures


def cell_views() -> dict[str, float]:
    """The views of the simulated cell while its arm swings; CameraError where EGL is missing."""
    config, figures = VideoConfig(), dict[str, float]()
    began = time.perf_counter()
    cell = build_cell(CellConfig(), RobotConfig(), dressed=True)
    figures["dressed cell built, ms"] = 1e3 * (time.perf_counter() - began)
    renderer = CellRenderer(cell, config.width, config.height)
    for camera in config.cameras:
        view, times_ms, sizes_kb = renderer.view_id(camera.name), [], []
        posture = cell.start().qpos.copy()
        renderer.render(view, posture)  # what stands still is drawn once
        for k in range(PAIRS):
            posture[cell.arm] = cell.start_q
            posture[1] += SWING_RAD * math.sin(k * STEP_S)
            start = time.perf_counter()
            picture = renderer.render(view, posture)
            times_ms.append(1e3 * (time.perf_counter() - start))
            sizes_kb.append(1e-3 * len(encode_jpeg(picture, config.quality)))
        figures[f"{camera.name}, median ms"] = statistics.median(times_ms)
        figures[f"{camera.name}, p95 ms"] = statistics.quantiles(times_ms, n=20)[-1]
        figures[f"{camera.name}, JPEG kB"] = statistics.mean(sizes_kb)
    renderer.close()
    return figures

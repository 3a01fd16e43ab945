"""What one camera frame costs: rendered, encoded, and through the whole video process's path; milliseconds each."""

import statistics
import time
from collections.abc import Callable
from functools import partial

import cv2

from remote_site.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.config import VideoConfig
from remote_site.video.encode import encode_jpeg

REPEATS = 60


def median_ms(call: Callable[[], object]) -> float:
    """The median processor time of a call in ms, of all threads of this process."""
    times = []
    for _ in range(REPEATS):
        before = time.process_time()
        call()
        times.append(1000.0 * (time.process_time() - before))
    return round(statistics.median(times), 3)


def measure() -> dict[str, float]:
    """The figures by name; CameraError where EGL is missing."""
    cv2.setNumThreads(1)
    config, figures = VideoConfig(), {}
    cell = build_cell(CellConfig(), RobotConfig())
    posture = cell.start().qpos
    renderer = CellRenderer(cell, config.width, config.height)
    for camera in config.cameras:
        view = renderer.view_id(camera.name)
        image = renderer.render(view, posture)
        figures[f"{camera.name}_render_ms"] = median_ms(partial(renderer.render, view, posture))
        figures[f"{camera.name}_encode_ms"] = median_ms(partial(encode_jpeg, image, config.quality))
    per_round = sum(figures.values())
    figures["core_share_percent"] = round(per_round * config.fps / 10.0, 1)
    renderer.close()
    return figures

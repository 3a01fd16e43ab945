"""What the four views cost in processor time and bytes, and what arrives through links of 20 and 5 Mbit/s."""

import statistics
import time
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial

import cv2
import numpy as np

from bench.video.link import Arrival, StreamRun
from common.cameras.camera import Image
from common.geometry import Array
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg, shrunk
from remote_site.video.streaming.setting import StreamSetting

REPEATS = 60
POSTURES = 10
SENSOR_NOISE = 3.0  # of a real camera, standard deviation of each value
LINKS_MBIT_S = (20.0, 5.0)
SETTLE_S, SECONDS = 5.0, 20.0

Pictures = dict[str, list[Image]]


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
    config = VideoConfig()
    figures: dict[str, float] = {}
    cell = build_cell(CellConfig(), RobotConfig())
    renderer = CellRenderer(cell, config.width, config.height)
    pictures: Pictures = {}
    for camera in config.cameras:
        view, posture = renderer.view_id(camera.name), cell.start().qpos.copy()
        figures |= costs(camera.name, config, partial(renderer.render, view, posture))
        pictures[camera.name] = filmed(partial(renderer.render, view), posture)
    renderer.close()
    per_round = sum(value for name, value in figures.items() if name.endswith("_ms"))
    figures["core_percent"] = round(per_round * config.fps / 10.0, 1)
    for mbit_s in LINKS_MBIT_S:
        figures |= carried(config, pictures, mbit_s)
    return figures


def costs(name: str, config: VideoConfig, render: Callable[[], Image]) -> dict[str, float]:
    """Processor time and bytes of one view at full quality."""
    image = render()
    size = len(encode_jpeg(image, config.quality))
    return {
        f"{name}_render_ms": median_ms(render),
        f"{name}_encode_ms": median_ms(partial(encode_jpeg, image, config.quality)),
        f"{name}_bytes": float(size),
        f"{name}_mbit_s": round(8e-6 * size * config.fps, 2),
    }


def filmed(render: Callable[[Array], Image], posture: Array) -> list[Image]:
    """Pictures of a moving arm with the noise of a real camera, which makes them harder to compress."""
    rng = np.random.default_rng(5)
    pictures = []
    for k in range(POSTURES):
        moved = posture.copy()
        moved[1] += 0.05 * k
        image = render(moved)
        noisy = image + rng.normal(0.0, SENSOR_NOISE, image.shape)
        pictures.append(np.clip(noisy, 0, 255).astype(np.uint8))
    return pictures


def carried(config: VideoConfig, pictures: Pictures, mbit_s: float) -> dict[str, float]:
    """What arrives of noisy pictures through a link, beside the same link without adaptation."""

    def picture(camera: str, seq: int, setting: StreamSetting) -> bytes:
        images = pictures[camera]
        return encode_jpeg(shrunk(images[seq % len(images)], setting.scale), setting.quality)

    run, as_it_is = (StreamRun(config, picture, mbit_s, reports=reports) for reports in (True, False))
    run.run(SETTLE_S)
    arrivals, unadapted = run.run(SECONDS), as_it_is.run(SETTLE_S)
    total = Counter[str]()
    for arrival in arrivals:
        total[arrival.camera] += arrival.size
    link, exposed = f"link_{mbit_s:g}", len(config.cameras) * config.fps * SECONDS
    return {
        f"{link}_frames_kept": round(len(arrivals) / exposed, 3),
        f"{link}_used": round(8e-6 * total.total() / SECONDS / mbit_s, 3),
        f"{link}_most_to_least_bytes": round(max(total.values()) / min(total.values()), 3),
        **{f"{link}_age_p{level}_ms": round(age_ms(arrivals, level), 1) for level in (50, 95, 100)},
        f"{link}_unadapted_age_p50_ms_after_{SETTLE_S:g}_s": round(age_ms(unadapted[-30:], 50), 1),
    }


def age_ms(arrivals: Sequence[Arrival], percentile: float) -> float:
    """A percentile of the pictures' ages."""
    return float(np.percentile([arrival.age_ms for arrival in arrivals], percentile))

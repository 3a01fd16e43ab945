"""Costs of the four views in processor time and bytes, and what arrives through links of 20, 5 and 2 Mbit/s."""

import statistics
import time
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial

import cv2
import numpy as np

from common.cameras.camera import Image
from common.geometry import Array
from common.messages.video import Codec
from lab.measure.video.coded import CodedCameras
from lab.measure.video.link import Arrival, StreamRun
from remote_site.kinematics.config import RobotConfig
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import CellConfig
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.config import VideoConfig
from remote_site.video.streaming.pictures import encode_jpeg
from remote_site.video.streaming.setting import StreamSetting

REPEATS = 60
POSTURES = 10
SENSOR_NOISE = 3.0  # of a real camera, standard deviation of each value
LINKS_MBIT_S = (20.0, 5.0, 2.0)
SETTLE_S, SECONDS = 8.0, 20.0
HELD_BYTES = 300_000  # in the buffers of a connection

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
    cell = build_cell(CellConfig(), RobotConfig(), dressed=True)
    renderer = CellRenderer(cell, config.width, config.height)
    pictures: Pictures = {}
    for camera in config.cameras:
        view, posture = renderer.view_id(camera.name), cell.start().qpos.copy()
        figures |= costs(camera.name, config, partial(renderer.render, view, posture))
        pictures[camera.name] = filmed(partial(renderer.render, view), posture)
    renderer.close()
    per_round = sum(value for name, value in figures.items() if name.endswith("_ms"))
    figures["core_percent"] = round(per_round * config.fps / 10.0, 1)
    for codec in Codec:
        figures |= coding(config, pictures, codec)
    for mbit_s in LINKS_MBIT_S:
        for h264 in (False, True):
            figures |= carried(config, pictures, mbit_s, h264=h264)
    return figures


def coding(config: VideoConfig, pictures: Pictures, codec: Codec) -> dict[str, float]:
    """Measure what a codec takes for noisy pictures of a moving arm where the link is free, and how close they stay."""
    cameras, setting = CodedCameras(config, pictures), StreamSetting(config.quality, 1.0, config.fps, codec)
    sizes = [len(cameras.picture(name, seq, setting).data) for seq in range(REPEATS) for name in pictures]
    return {
        f"{codec.value}_ms": round(statistics.median(cameras.encode_ms), 3),
        f"{codec.value}_mbit_s": round(8e-6 * statistics.fmean(sizes) * config.fps * len(pictures), 2),
        f"{codec.value}_ssim": round(statistics.fmean(cameras.ssims), 4),
    }


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


def carried(config: VideoConfig, pictures: Pictures, mbit_s: float, *, h264: bool) -> dict[str, float]:
    """Measure what arrives of noisy pictures through a link, at a page that decodes H.264 or does not."""
    cameras = CodedCameras(config, pictures)
    run = StreamRun(config, cameras.picture, mbit_s, h264=h264)
    run.link.holds_bytes = HELD_BYTES
    run.run(SETTLE_S)
    cameras.ssims.clear()
    arrivals = run.run(SECONDS)
    total = Counter[str]()
    for arrival in arrivals:
        total[arrival.camera] += arrival.size
    link, exposed = f"link_{mbit_s:g}{'_h264' if h264 else '_jpeg'}", len(config.cameras) * config.fps * SECONDS
    return {
        f"{link}_frames_kept": round(len(arrivals) / exposed, 3),
        f"{link}_used": round(8e-6 * total.total() / SECONDS / mbit_s, 3),
        f"{link}_most_to_least_bytes": round(max(total.values()) / min(total.values()), 3),
        **{f"{link}_age_p{level}_ms": round(age_ms(arrivals, level), 1) for level in (50, 95, 100)},
        f"{link}_ssim": round(statistics.fmean(cameras.ssims), 4),
    }


def age_ms(arrivals: Sequence[Arrival], percentile: float) -> float:
    """A percentile of the pictures' ages."""
    return float(np.percentile([arrival.age_ms for arrival in arrivals], percentile))

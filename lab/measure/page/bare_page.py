"""The baseline: the page fed by this process, which draws the clock into the same pictures, encodes and sends them."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from common.cameras.camera import Image
from common.messages.requests import Description
from common.messages.video import Codec
from lab.measure.page.ages import Figures, painting
from lab.measure.page.bare_console import BareConsole
from lab.measure.page.chromium import Chromium
from lab.measure.video.link import live_frame
from lab.stage.clock_strip import draw_clock
from local_site.console.hub import Hub
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.request_server import describe
from remote_site.simulation.cell import build_cell
from remote_site.video.cell_cameras import CellRenderer
from remote_site.video.streaming.encoding import Encoded
from remote_site.video.streaming.pictures import encode_jpeg

MEASURE_S = 15.0


def bare_figures() -> Figures:
    """Ages of the pictures and the browser's processor time, without sites and links."""
    config = RemoteConfig()
    model = ArmModel.from_urdf(config.robot.urdf, config.robot.tool_frame, config.robot.tool_T_tcp)
    cell = describe(config, model, JointLimits.from_model(model, config.robot))
    pictures = rendered(config)
    with Chromium() as chromium, BareConsole() as console, feeding(console, cell, pictures):
        return painting(chromium, chromium.open(console.address), MEASURE_S).figures("bare")


def rendered(config: RemoteConfig) -> dict[str, Image]:
    """A picture (H, W, 3) of every view, by the view's name."""
    cell = build_cell(config.simulation, config.robot, dressed=True)
    renderer = CellRenderer(cell, config.video.width, config.video.height)
    names = [camera.name for camera in config.video.cameras]
    pictures = {name: renderer.render(renderer.view_id(name), cell.start().qpos.copy()) for name in names}
    renderer.close()
    return pictures


@contextmanager
def feeding(console: BareConsole, cell: Description, pictures: dict[str, Image]) -> Iterator[None]:
    """Send pictures of all views in turn, 30 a second of each, the time drawn into them, while the block lasts."""
    ended = threading.Event()

    def feed() -> None:
        console.feed(lambda hub: hub.described(cell))
        period_s, seq, due_s = 1 / 30 / len(pictures), 0, time.monotonic()
        while not ended.wait(max(0.0, due_s - time.monotonic())):
            name = tuple(pictures)[seq % len(pictures)]
            image, now_ns = pictures[name], time.monotonic_ns()
            draw_clock(image, now_ns)
            encoded = Encoded(Codec.JPEG, True, image.shape[1], image.shape[0], encode_jpeg(image, 80))
            frame = live_frame(name, seq, now_ns, encoded)
            console.feed(partial(Hub.camera, frame=frame))
            seq, due_s = seq + 1, due_s + period_s

    thread = threading.Thread(target=feed, name="pictures", daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()

"""The page of a stepped site with the cell's views; skips where this machine cannot render."""

import numpy as np
import pytest
from msgspec.structs import replace

from common.errors import CameraError
from common.messages.robot import GripperStatus
from lab.experiments.placing.streamed_views import PICTURE_NS, StreamedViews
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import SteppedSite
from lab.visual_operator.shown import ShownPage
from remote_site.config import RemoteConfig

SETTLED_TICKS = 50


def config(x_m: float = 0.53, y_m: float = 0.04, yaw_deg: float = 0.0) -> RemoteConfig:
    """A cell whose block starts there."""
    base = RemoteConfig()
    block = replace(base.simulation.block, centre_xy_m=(x_m, y_m), yaw_deg=yaw_deg)
    video = replace(base.video, calibrated=True, fps=10.0)
    return replace(base, video=video, simulation=replace(base.simulation, block=block))


def page_of(cell_config: RemoteConfig) -> tuple[SteppedSite[SteppedCell], ShownPage]:
    """The site at rest, and its page."""
    site = SteppedSite(cell_config, SteppedCell(cell_config))
    for _ in range(SETTLED_TICKS):
        site.tick(())
    try:
        streamed = StreamedViews(cell_config, site.robot.memory, site.description, None, np.random.default_rng(0))
    except CameraError as error:
        pytest.skip(str(error))
    streamed.expose(site.now_ns)
    views = streamed.page(site.now_ns + PICTURE_NS)
    opening_m = cell_config.simulation.gripper.max_opening_m
    return site, ShownPage(site.now_ns, views, site.snapshot.state, "ok", "", opening_m, GripperStatus.OPEN, 0.0)

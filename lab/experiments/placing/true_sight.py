"""The operator's sight replaced by the truth, as late as pictures would come: to find out what seeing costs."""

from collections import deque
from collections.abc import Mapping

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array, transform
from lab.experiments.stepped.robots import SteppedCell
from lab.experiments.stepped.site import Every, SteppedSite
from lab.visual_operator.shown import ShownPage, ShownView
from lab.visual_operator.sight.sight import Scene
from remote_site.config import RemoteConfig
from remote_site.simulation.config import BLOCK


class TrueSight:
    """Takes the simulation's poses at each exposure instead of pictures, and hands them out as the pages come."""

    def __init__(self, config: RemoteConfig, site: SteppedSite[SteppedCell]) -> None:
        self._data = site.robot.cell.data
        self._exposures = Every(round(NS_PER_S / config.video.fps), site.now_ns)
        scene = config.simulation.scene
        self._target = transform(np.eye(3), np.array([*scene.target_corner_xy_m, scene.table_z_m]))
        self._scenes: deque[Scene] = deque()

    def expose(self, now_ns: int) -> None:
        """Remember the scene, as often as pictures would be taken."""
        if self._exposures.due(now_ns):
            self._scenes.append(Scene(now_ns, self._body(BLOCK), self._fingers(), self._target))

    def page(self, now_ns: int) -> Mapping[str, ShownView]:
        """There are no pictures."""
        del now_ns
        return {}

    def see(self, shown: ShownPage) -> Scene:
        """The scene of the oldest exposure not yet seen."""
        del shown
        return self._scenes.popleft()

    def _body(self, name: str) -> Array:
        body = self._data.body(name)
        return transform(body.xmat.reshape(3, 3).copy(), body.xpos.copy())

    def _fingers(self) -> Array:
        left, right = (self._data.geom(name).xpos for name in ("finger_left", "finger_right"))
        return transform(self._body("gripper_body")[:3, :3], (left + right) / 2)

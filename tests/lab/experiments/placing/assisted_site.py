"""The stepped site with its cameras' pictures looked at for markers, and a hand that is where a test wants it."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec.structs import replace

from common.cameras.camera import Frame, Image
from common.clock import NS_PER_MS, FakeClock
from common.config.loading import load_config
from common.geometry import Array, angle_between, transform
from common.messages.hand import Intent
from farhand.deployment.shipped import HERE
from lab.stage.stepped.robots import SteppedCell
from lab.stage.stepped.site import LEASE, OPERATOR, SESSION, SteppedSite
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import load_arm
from remote_site.session.config import EngagementMode
from remote_site.session.samples import NamedSample
from remote_site.simulation.cell import build_cell
from remote_site.simulation.config import BLOCK
from remote_site.video.calibration import calibration_of
from remote_site.video.cell_cameras import CellCamera, open_cell_cameras
from remote_site.video.marker_look import MarkerLook
from tests.remote_site.remote_loop import hand

SAMPLE_TICKS, PICTURE_TICKS = 8, 40
SHIPPED = HERE / "sites" / "remote-assist.toml"
HAND = np.array([0.0, 0.0, 0.3])


def assisted_config(yaw_deg: float = 0.0) -> RemoteConfig:
    """The shipped example, the block turned."""
    config = load_config(RemoteConfig, SHIPPED).engaging(EngagementMode.AUTOMATIC)
    block = replace(config.simulation.block, yaw_deg=yaw_deg)
    return replace(config, simulation=replace(config.simulation, block=block))


class AssistedSite:
    """The whole remote site on stepped time, with an operator's hand and key."""

    def __init__(self, config: RemoteConfig) -> None:
        self.site, self.config = SteppedSite(config, SteppedCell(config)), config
        self.model, _ = load_arm(config.robot)
        self.cameras = self._open()
        self.hand, self._ticks, self._seq = HAND.copy(), 0, 0
        self._sightings: list[MarkerSighting] = []
        views = {
            c.name: calibration_of(c, config.video, config.simulation, config.robot.tool_T_tcp)
            for c in config.video.cameras
        }
        calibrated = {name: view for name, view in views.items() if view is not None}
        self._look = MarkerLook(config.assist, calibrated, self._tool_at, self._sightings.extend, FakeClock())
        self.paint: Callable[[str, Image], None] = lambda _name, _picture: None
        self.toggles = 0

    def _open(self) -> list[CellCamera]:
        names = [camera.name for camera in self.config.video.cameras]
        cell = build_cell(self.config.simulation, self.config.robot, dressed=True)
        return open_cell_cameras(names, cell, self.site.robot.memory.snapshot, self.config.video)

    def close(self) -> None:
        """Release what renders the views."""
        for camera in self.cameras:
            camera.close()

    @property
    def tool(self) -> Array:
        """Where the physics have the tool centre point (4 x 4)."""
        data = self.site.robot.cell.data
        return self.model.forward(np.array(data.qpos[self.site.robot.cell.cell.arm]))

    def goal(self, name: str) -> Array:
        """Where the tool belongs (4 x 4), by the physics' truth."""
        target = next(t for t in self.config.assist.targets if t.name == name)
        printed = next(m for m in self.config.simulation.printed_markers if m.marker == target.marker)
        parent = np.eye(4)
        if printed.on == BLOCK:
            body = self.site.robot.cell.data.body(BLOCK)
            parent = transform(body.xmat.reshape(3, 3).copy(), body.xpos.copy())
        return parent @ printed.parent_T_marker @ target.marker_T_tool

    def miss(self, name: str) -> tuple[float, float]:
        """How far the tool is from a target, mm and deg."""
        tool, goal = self.tool, self.goal(name)
        return 1e3 * math.dist(tool[:3, 3], goal[:3, 3]), math.degrees(angle_between(tool[:3, :3], goal[:3, :3]))

    def go(self, seconds: float, asks_for: str | None = None, moves: tuple[float, float, float] = (0, 0, 0)) -> None:
        """Run; the tool is moved evenly by so many m in the base's frame, the key held for a target."""
        ticks = round(250 * seconds)
        base_R_operator = np.array(self.config.mapping.base_R_operator)
        step = base_R_operator.T @ np.array(moves) / ticks
        for _ in range(ticks):
            self.hand += step
            self._tick(Intent(assist=asks_for))

    def _tick(self, intent: Intent) -> None:
        self._ticks += 1
        now_ns, samples = self.site.now_ns, []
        if self._ticks % PICTURE_TICKS == 0:
            for camera in self.cameras:
                self._show(camera, now_ns)
        if self._ticks % SAMPLE_TICKS == 0:
            self._seq += 1
            x, y, z = self.hand.tolist()
            fields: dict[str, Any] = {"lease": LEASE, "intent": intent, "gripper_toggles": self.toggles}
            sample = hand(self._seq, now_ns - 20 * NS_PER_MS, (x, y, z), SESSION, **fields)
            samples = [NamedSample(OPERATOR, sample)]
        sightings = tuple(self._sightings)
        self._sightings.clear()
        self.site.tick(samples, sightings)

    def _show(self, camera: CellCamera, now_ns: int) -> None:
        frame = camera.newest()
        if frame is not None:
            picture = frame.image.copy()
            self.paint(camera.name, picture)
            self._look.see(camera.name, Frame(picture, frame.capture_ns, frame.seq), now_ns)

    def _tool_at(self, _t_ns: int) -> Array:
        return self.tool

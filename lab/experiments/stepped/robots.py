"""Robots in simulated time, each with its driver: the physics of the cell, and the emulated controller of the A465."""

import numpy as np

from common.clock import Clock
from common.geometry import Array
from lab.experiments.stepped.site import BEGIN_NS
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation
from remote_site.drivers.c500c.emulator import Emulated, EmulatedController
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell

EMULATED_STEP_S = 0.001  # the serial line moves its bytes as often


class SteppedCell:
    """The MuJoCo cell with its robot controller; `memory` is what the views are drawn from, `cell` the simulation."""

    def __init__(self, config: RemoteConfig) -> None:
        self._joints = len(config.robot.start_deg)
        self.memory = CellMemory.create(self._joints)
        self.cell = SimulatedCell(config.simulation, config.robot, self.memory)
        self.dt_s: float = self.cell.dt

    def driver(self, clock: Clock) -> SimulatedDriver:
        """The driver that talks to it."""
        return SimulatedDriver(self.memory, clock)

    def step(self, now_ns: int) -> None:
        """One period of control and physics, which ends now."""
        self.cell.step(now_ns, now_ns)

    @property
    def q(self) -> Array:
        """The true joint positions, (n,) in rad."""
        q: Array = self.cell.data.qpos[: self._joints].copy()
        return q

    @property
    def block_xy_m(self) -> Array:
        """The position of the block's middle, (2,) in the base frame."""
        xy: Array = self.cell.data.body("block").xpos[:2].copy()
        return xy


class SteppedController:
    """The emulated controller of the A465 behind its serial line; the fingers close on `emulated.object_m`."""

    dt_s = EMULATED_STEP_S

    def __init__(self, config: RemoteConfig, emulated: Emulated) -> None:
        self._controller = EmulatedController(np.array(config.robot.start), emulated)
        self._emulation = Emulation(self._controller, BEGIN_NS)
        self._options = C500cConfig()

    def driver(self, clock: Clock) -> C500cDriver:
        """The driver that talks to it."""
        return C500cDriver(self._options, EmulatedPort(self._emulation, clock), clock)

    def step(self, now_ns: int) -> None:
        """Nothing: line and controller catch up whenever the driver reads, which it does after every step."""

    @property
    def q(self) -> Array:
        """The true joint positions, (6,) in rad."""
        return self._controller.player.q.copy()

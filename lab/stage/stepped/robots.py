"""Robots in simulated time, each with its driver, and the clock that steps them: the MuJoCo cell, an emulated A465."""

from collections.abc import Callable
from typing import Protocol

from common.clock import NS_PER_S, Clock, FakeClock
from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation
from remote_site.drivers.c500c.emulator import Emulated, EmulatedController
from remote_site.drivers.driver import Driver
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell

BEGIN_NS = NS_PER_S  # not 0: that stands for no sample
EMULATED_STEP_S = 0.001  # the serial line moves its bytes as often


class SteppedRobot(Protocol):
    """A robot whose own time advances with each step of `dt_s`; `q` (n,) in rad is where its joints truly are."""

    dt_s: float

    @property
    def q(self) -> Array: ...

    def driver(self, clock: Clock) -> Driver: ...

    def step(self, now_ns: int) -> None: ...


class SteppedClock(FakeClock):
    """A fake clock from BEGIN_NS on that steps a robot, and then what is set as `after_step`, as its time advances."""

    def __init__(self, robot: SteppedRobot) -> None:
        super().__init__(BEGIN_NS)
        self._robot, self._stepped_ns, self._step_ns = robot, BEGIN_NS, round(robot.dt_s * NS_PER_S)
        self.after_step: Callable[[], None] = lambda: None

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Advance to a time, ns, with every step of the robot that is due until then."""
        while self._stepped_ns + self._step_ns <= deadline_ns:
            self._stepped_ns += self._step_ns
            self.time_ns = max(self.time_ns, self._stepped_ns)
            self._robot.step(self._stepped_ns)
            self.after_step()
        super().sleep_until_ns(deadline_ns)


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
    """The emulated controller of the A465 behind its serial line; the fingers close on `emulated.object_m`.

    The line loses the fraction `loss` of its bytes.
    """

    dt_s = EMULATED_STEP_S

    def __init__(self, config: RemoteConfig, emulated: Emulated, loss: float = 0.0) -> None:
        self.controller = EmulatedController(config.robot.start, emulated)
        self._emulation = Emulation(self.controller, BEGIN_NS, loss=loss)

    def driver(self, clock: Clock) -> C500cDriver:
        """The driver that talks to it."""
        return C500cDriver(C500cConfig(), EmulatedPort(self._emulation, clock), clock)

    def step(self, now_ns: int) -> None:
        """Nothing: line and controller catch up whenever the driver reads, which it does after every step."""

    @property
    def q(self) -> Array:
        """The true joint positions, (6,) in rad."""
        return self.controller.player.q.copy()

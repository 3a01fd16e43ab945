"""The remote site from control to robot on stepped time, which can be started again while its robot continues."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Self

import msgspec

from common.clock import NS_PER_MS, FakeClock
from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, GripperStatus, SessionState
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.driver import C500cDriver
from remote_site.drivers.c500c.emulation import EmulatedPort, Emulation
from remote_site.drivers.c500c.emulator import Emulated, EmulatedController
from remote_site.drivers.driver import Driver
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.simulated import SimulatedDriver
from remote_site.drivers.supervisor.grip import GripWatch
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.driver_process import DriverLoop, grip_settings, setup_of
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import NamedSample
from remote_site.simulation.memory import CellMemory
from remote_site.simulation.process import SimulatedCell
from remote_site.teleop.cycle import Snapshot
from remote_site.teleop.pipeline import TeleopPipeline
from tests.contracts.driver_stands import CellClock
from tests.remote_site.remote_loop import FOR_EVER_NS, LEASE, hand

CONFIG = msgspec.structs.replace(RemoteConfig(), engagement=EngagementConfig(mode=EngagementMode.ON_REQUEST, frames=3))
MODEL, LIMITS = load_arm(CONFIG.robot)
TURN_MS, TURNS_PER_TICK, TICKS_PER_SAMPLE = 2, 2, 8
OBJECT_M = 0.03  # between the fingers of the A465


@dataclass
class Robot:
    """A robot that outlives the remote site: its clock, what makes a driver for it, the opening of its gripper in m."""

    clock: FakeClock
    make: Callable[[], Driver]
    opening_m: Callable[[], float]
    open_by_hand: Callable[[], None]


def simulated_closed() -> Robot:
    """The arm of the simulated cell, its gripper closed on nothing."""
    memory = CellMemory.create(6)
    cell = SimulatedCell(CONFIG.simulation, CONFIG.robot, memory)
    clock = CellClock(cell)

    def command(gripper: GripperCommand) -> None:
        cell.controller.gripper = gripper

    command(GripperCommand.CLOSED)
    clock.sleep_until_ns(clock.now_ns() + 1000 * NS_PER_MS)
    opening = partial(_opening_m, memory)
    return Robot(clock, lambda: SimulatedDriver(memory, clock), opening, partial(command, GripperCommand.OPEN))


def _opening_m(memory: CellMemory) -> float:
    return float(memory.reading.read()["opening_m"])


def a465_holding() -> Robot:
    """An A465 with an object of 30 mm in its gripper, whose force is not measured."""
    clock = FakeClock(1000 * NS_PER_MS)
    controller = EmulatedController(CONFIG.robot.start, Emulated(object_m=OBJECT_M))
    gripper = controller.gripper
    gripper.opening_m, gripper.aim_open = OBJECT_M, False
    port = EmulatedPort(Emulation(controller, clock.now_ns()), clock)
    opened = partial(gripper.order, GripperCommand.OPEN, 50)
    return Robot(clock, lambda: C500cDriver(C500cConfig(), port, clock), lambda: gripper.opening_m, opened)


class StartedSite:
    """Pipeline, supervisor and driver, started now; `toggles` is the count in the hand samples to come."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.clock = robot, robot.clock
        memory, driver, setup = DriverMemory.create(6), robot.make(), setup_of(CONFIG)
        driver.configure(setup)
        grip = GripWatch(grip_settings(CONFIG))
        self.supervisor = DriverSupervisor(driver, setup, self.clock, memory.busy, grip)
        self._loop = DriverLoop(self.supervisor, memory, self.clock)
        self.link = DriverLink(memory, LIMITS, self.clock)
        self.driven = DrivenPipeline(TeleopPipeline(CONFIG, MODEL, LIMITS), self.link)
        self._leases = LeaseServer(FOR_EVER_NS, LEASE)
        self._lease = self._leases.acquire(Holder(7, "anna"), self.clock.now_ns())
        self._seq = self.toggles = 0
        self.snapshot: Snapshot

    def ready(self) -> Self:
        """The same, its robot activated where it is, as control does at its start."""
        self._turn_robot(200)
        self.link.activate(self.link.read().q)
        self._turn_robot(200)
        assert self.link.read().ready
        return self

    def hand_over(self, operator: str) -> None:
        """Have another operator hold the lease, whose hand has toggled nothing yet."""
        assert isinstance(self._lease, Lease)
        now_ns, holder = self.clock.now_ns(), self._lease.holder
        self._leases.release(self._lease.number, holder, now_ns)
        self._lease = self._leases.acquire(Holder(holder.session + 1, operator), now_ns)
        self.toggles = 0

    def engaged(self) -> Self:
        """The same, following a hand at rest."""
        self.run(300)
        self.run(TURN_MS * TURNS_PER_TICK, EngagementAction.ENGAGE)
        self.run(100)
        assert self.snapshot.state is SessionState.ENGAGED, self.snapshot.reason
        return self

    @property
    def status(self) -> GripperStatus:
        """The gripper's, as reported to control."""
        gripper = self.driven.report.gripper
        assert gripper is not None
        return gripper.status

    def closed(self) -> Self:
        """The same, its gripper closed by a toggle."""
        self.toggled(1)
        if self.snapshot.gripper_next is GripperCommand.CLOSED:
            self.toggled(1)
        assert self.status in (GripperStatus.CLOSED, GripperStatus.HOLDING)
        return self

    def toggled(self, count: int) -> None:
        """Toggle the gripper this often, each time until it has done what it should."""
        for _ in range(count):
            self.toggles += 1
            self.run(1500)

    def run(self, ms: float, *actions: EngagementAction) -> None:
        """Let time pass with a hand at rest; the operator asks for these in the first tick."""
        assert isinstance(self._lease, Lease)
        number, holder = self._lease.number, self._lease.holder
        seen_ns = self.snapshot.halted_ns if actions else 0
        requests = [SessionRequest(action, holder.name, seen_ns=seen_ns) for action in actions]
        for turn in range(round(ms / TURN_MS)):
            self._turn_robot(TURN_MS)
            if turn % TURNS_PER_TICK:
                continue
            samples = []
            if turn % (TURNS_PER_TICK * TICKS_PER_SAMPLE) == 0:
                self._seq += 1
                now_ns = self.clock.now_ns()
                sample = hand(self._seq, now_ns, session=holder.session, lease=number, gripper_toggles=self.toggles)
                samples = [NamedSample(holder.name, sample)]
            now_ns = self.clock.now_ns()
            self.snapshot = self.driven.cycle(now_ns, self._leases.status(now_ns), samples, requests)
            requests = []

    def _turn_robot(self, ms: float) -> None:
        for _ in range(round(ms / TURN_MS)):
            self.clock.sleep_until_ns(self.clock.now_ns() + TURN_MS * NS_PER_MS)
            self._loop.turn()

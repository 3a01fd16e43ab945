"""The remote site from control to robot on stepped time, which can be started again while its robot continues."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Self

import msgspec

from common.clock import NS_PER_MS, FakeClock
from common.messages.requests import EngagementAction
from common.messages.robot import GripperCommand, GripperStatus, SessionState
from lab.stage.stepped.driver_process import SteppedDriverProcess
from lab.stage.stepped.robots import SteppedCell, SteppedClock, SteppedController
from remote_site.config import RemoteConfig
from remote_site.drivers.c500c.emulator import Emulated
from remote_site.drivers.driver import Driver
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import NamedSample
from remote_site.simulation.memory import CellMemory
from remote_site.teleop.cycle import Snapshot
from tests.remote_site.remote_loop import FOR_EVER_NS, LEASE, hand

CONFIG = msgspec.structs.replace(RemoteConfig(), engagement=EngagementConfig(mode=EngagementMode.ON_REQUEST, frames=3))
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
    cell = SteppedCell(CONFIG)
    clock = SteppedClock(cell)

    def command(gripper: GripperCommand) -> None:
        cell.cell.controller.gripper = gripper

    command(GripperCommand.CLOSED)
    clock.sleep_until_ns(clock.now_ns() + 1000 * NS_PER_MS)
    opening, opened = partial(_opening_m, cell.memory), partial(command, GripperCommand.OPEN)
    return Robot(clock, partial(cell.driver, clock), opening, opened)


def _opening_m(memory: CellMemory) -> float:
    return float(memory.reading.read()["opening_m"])


def a465_holding() -> Robot:
    """An A465 with an object of 30 mm in its gripper, whose force is not measured."""
    a465 = SteppedController(CONFIG, Emulated(object_m=OBJECT_M))
    clock, gripper = SteppedClock(a465), a465.controller.gripper
    gripper.opening_m, gripper.aim_open = OBJECT_M, False
    opened = partial(gripper.order, GripperCommand.OPEN, 50)
    return Robot(clock, partial(a465.driver, clock), lambda: gripper.opening_m, opened)


class StartedSite:
    """Pipeline, supervisor and driver, started now; `toggles` is the count in the hand samples to come."""

    def __init__(self, robot: Robot) -> None:
        self.robot, self.clock = robot, robot.clock
        self._process = SteppedDriverProcess(CONFIG, robot.make(), self.clock)
        self.supervisor, self.link = self._process.supervisor, self._process.link
        self.driven = self._process.pipeline()
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
            self._process.turn()

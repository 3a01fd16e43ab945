"""Pipeline, supervisor and driver on stepped time: control ticks every 4 ms unless it stalls."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

import msgspec

from bench.soak.operator import RandomOperator
from bench.soak.robot import FaultInjectingDriver
from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import Driver
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.supervisor.grip import GripWatch
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.driver_process import DriverLoop, grip_settings, setup_of
from remote_site.runtime.rate import Rate
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.session.state_machine import FOLLOWING
from remote_site.teleop.cycle import Snapshot
from remote_site.teleop.pipeline import TeleopPipeline

CONFIG = msgspec.structs.replace(RemoteConfig(), engagement=EngagementConfig(mode=EngagementMode.ON_REQUEST, frames=10))
TURN_NS = 2 * NS_PER_MS
ASK_NS = 300 * NS_PER_MS
TICKS_PER_STALL = 400  # on average
STALL_MS, LONG_STALL_MS = (1, 150), (300, 900)
LONG_FRACTION = 0.25
FOR_EVER_NS = 10**15

MakeRobot = Callable[[RemoteConfig], tuple[FakeClock, Driver]]


@dataclass
class Ticks:
    """What control decided: when, in which state, and when the sample it obeyed was born, 0 while it obeyed none."""

    t_ns: list[int] = field(default_factory=list)
    states: list[SessionState] = field(default_factory=list)
    born_ns: list[int] = field(default_factory=list)
    faults: Counter[str] = field(default_factory=Counter)
    stalls: int = 0
    engagements: int = 0


class World:
    """One arm from operator to robot; `run` lets time pass."""

    def __init__(self, make: MakeRobot, seed: int) -> None:
        self._luck = Random(seed)  # noqa: S311  # what goes wrong is no secret
        self.clock, driver = make(CONFIG)
        robot, begin_ns = CONFIG.robot, self.clock.now_ns()
        self.model, self.limits = load_arm(robot)
        self.driver = FaultInjectingDriver(driver, self._luck, self.clock, self._only_control)
        setup, memory = setup_of(CONFIG), DriverMemory.create(len(robot.start_deg))
        self.driver.configure(setup)
        self._supervisor = DriverSupervisor(
            self.driver, setup, self.clock, memory.busy, GripWatch(grip_settings(CONFIG))
        )
        self._driver_loop, link = (
            DriverLoop(self._supervisor, memory, self.clock),
            DriverLink(memory, self.limits, self.clock),
        )
        self.operator = RandomOperator(self._luck, LeaseServer(FOR_EVER_NS, 1), begin_ns)
        self._driven = DrivenPipeline(TeleopPipeline(CONFIG, self.model, self.limits), link)
        self.ticks, self._last_fault = Ticks(), ""
        self._rate = Rate(CONFIG.control.rate_hz, self.clock, least_share=LEAST_FRACTION)
        self._control_ns = self._rate.next_ns
        self._turn_ns, self._ask_ns = begin_ns, begin_ns + ASK_NS
        link.activate(robot.start)

    def run(self, seconds: float) -> None:
        """Let so much time pass."""
        end_ns = self.clock.now_ns() + round(seconds * NS_PER_S)
        while self.clock.now_ns() < end_ns:
            if self._control_ns <= self._turn_ns:
                self._only_control(self._control_ns)
            else:
                self.clock.sleep_until_ns(self._turn_ns)
            ticks = len(self.ticks.t_ns)
            self._driver_loop.turn()  # every order wakes the driver's process, also one that came while a call was late
            pause_ns = TURN_NS + round(self._luck.uniform(0, 0.3) * NS_PER_MS)
            self._turn_ns = self.clock.now_ns() + (pause_ns if len(self.ticks.t_ns) == ticks else 0)
            if self._supervisor.due_ns is not None:
                self._turn_ns = min(self._turn_ns, max(self._supervisor.due_ns, self.clock.now_ns()))

    def _only_control(self, until_ns: int) -> None:
        """Let time pass for everybody but the driver's process."""
        while self._control_ns <= until_ns:
            self.clock.sleep_until_ns(self._control_ns)
            self._rate.wait()
            self._tick(self.clock.now_ns())
            self._control_ns = self._rate.next_ns + self._stall_ns()
        self.clock.sleep_until_ns(until_ns)

    def _stall_ns(self) -> int:
        """How late control will be for its next deadline."""
        if self._luck.random() * TICKS_PER_STALL > 1.0:
            return 0
        self.ticks.stalls += 1
        long = self._luck.random() < LONG_FRACTION
        return round(self._luck.uniform(*(LONG_STALL_MS if long else STALL_MS)) * NS_PER_MS)

    def _tick(self, now_ns: int) -> None:
        leases = self.operator.leases
        samples = self.operator.arrived(now_ns)
        self._note(now_ns, self._driven.cycle(now_ns, leases.status(now_ns), samples, self._requests(now_ns)))

    def _requests(self, now_ns: int) -> list[SessionRequest]:
        """Now and then somebody resets the arm, and the lease's holder asks to engage."""
        lease = self.operator.leases.current(now_ns)
        if (self.ticks.states and self.ticks.states[-1] in FOLLOWING) or now_ns < self._ask_ns or lease is None:
            return []
        self._ask_ns = now_ns + ASK_NS + round(self._luck.uniform(0, 500) * NS_PER_MS)
        actions = (EngagementAction.RESET, EngagementAction.ENGAGE)
        return [SessionRequest(action, lease.holder.name) for action in actions]

    def _note(self, now_ns: int, snapshot: Snapshot) -> None:
        ticks, fault = self.ticks, self._driven.report.fault
        ticks.t_ns.append(now_ns)
        ticks.states.append(snapshot.state)
        ticks.born_ns.append(snapshot.obeys.born_ns if snapshot.obeys is not None else 0)
        ticks.engagements = snapshot.engagements
        code = fault.code.value if fault is not None and not fault.calm else ""
        if code and code != self._last_fault:
            ticks.faults[code] += 1
        self._last_fault = code

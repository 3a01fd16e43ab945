"""Pipeline, supervisor and driver on stepped time: control ticks every 4 ms unless it stalls."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from random import Random

import msgspec

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.messages.requests import EngagementAction
from common.messages.robot import FOLLOWING, SessionState
from lab.measure.soak.operator import RandomOperator
from lab.measure.soak.robot import FaultInjectingDriver
from lab.stage.stepped.driver_process import SteppedDriverProcess
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import Driver
from remote_site.drivers.faults import RobotFault
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION
from remote_site.runtime.rate import Rate
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.teleop.cycle import Snapshot

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
    """The decisions of control: when, in which state, when the obeyed sample was captured, 0 while it obeyed none.

    `age_limit_ns` is the age up to which samples were obeyed, `halted_ns` when the newest halt came.
    """

    t_ns: list[int] = field(default_factory=list)
    states: list[SessionState] = field(default_factory=list)
    born_ns: list[int] = field(default_factory=list)
    age_limit_ns: list[int] = field(default_factory=list)
    faults: Counter[str] = field(default_factory=Counter)
    engagements: int = 0
    halted_ns: int = 0
    _last_fault: str = ""

    def append(self, now_ns: int, snapshot: Snapshot, fault: RobotFault | None) -> None:
        """Record a tick; a fault counts once, however long it lasts."""
        self.t_ns.append(now_ns)
        self.states.append(snapshot.state)
        self.born_ns.append(snapshot.obeys.born_ns if snapshot.obeys is not None else 0)
        self.age_limit_ns.append(round(snapshot.age_limit_ms * NS_PER_MS))
        self.engagements, self.halted_ns = snapshot.engagements, snapshot.halted_ns
        code = fault.code.value if fault is not None and not fault.calm else ""
        if code and code != self._last_fault:
            self.faults[code] += 1
        self._last_fault = code


class StallingTimer:
    """The deadlines of control's ticks: on time, but for pauses at random, counted in `stalls`."""

    def __init__(self, rng: Random, clock: FakeClock) -> None:
        self._rng, self._clock = rng, clock
        self._rate = Rate(CONFIG.control.rate_hz, clock, least_fraction=LEAST_FRACTION)
        self.due_ns = self._rate.next_ns
        self.stalls = 0

    def wait(self) -> int:
        """Let time pass until the next tick; its time."""
        self._clock.sleep_until_ns(self.due_ns)
        self._rate.wait()
        return self._clock.now_ns()

    def schedule(self) -> None:
        """Choose when the next tick is due."""
        self.due_ns = self._rate.next_ns + self._stall_ns()

    def _stall_ns(self) -> int:
        """Draw how late control is for its next deadline, ns."""
        if self._rng.random() * TICKS_PER_STALL > 1.0:
            return 0
        self.stalls += 1
        long = self._rng.random() < LONG_FRACTION
        return round(self._rng.uniform(*(LONG_STALL_MS if long else STALL_MS)) * NS_PER_MS)


class DriverTurns:
    """The turns of the driver's process; `next_ns` is when its next is due."""

    def __init__(self, process: SteppedDriverProcess, rng: Random, clock: FakeClock) -> None:
        self._process, self._rng, self._clock = process, rng, clock
        self.next_ns = clock.now_ns()

    def turn(self) -> None:
        """Run one turn; the next is due after a short pause, or as soon as the supervisor has something to write."""
        self._process.turn()
        now_ns, due_ns = self._clock.now_ns(), self._process.supervisor.due_ns
        self.next_ns = now_ns + TURN_NS + round(self._rng.uniform(0, 0.3) * NS_PER_MS)
        if due_ns is not None:
            self.next_ns = min(self.next_ns, max(due_ns, now_ns))

    def wake(self) -> None:
        """Make the next turn due now."""
        self.next_ns = self._clock.now_ns()


class World:
    """One arm from operator to robot; `run` lets time pass."""

    def __init__(self, make: MakeRobot, seed: int) -> None:
        self._rng = Random(seed)  # noqa: S311  # the faults need not be secret
        self.clock, driver = make(CONFIG)
        self.driver = FaultInjectingDriver(driver, self._rng, self.clock, self._run_control)
        begin_ns, process = self.clock.now_ns(), SteppedDriverProcess(CONFIG, self.driver, self.clock)
        self.model, self.limits = process.model, process.limits
        self._turns = DriverTurns(process, self._rng, self.clock)
        self.operator = RandomOperator(self._rng, LeaseServer(FOR_EVER_NS, 1), begin_ns)
        self._driven = process.pipeline()
        self.ticks, self.timer = Ticks(), StallingTimer(self._rng, self.clock)
        self._ask_ns = begin_ns + ASK_NS
        process.link.activate(CONFIG.robot.start)

    def run(self, seconds: float) -> None:
        """Let this much time pass."""
        end_ns = self.clock.now_ns() + round(seconds * NS_PER_S)
        while self.clock.now_ns() < end_ns:
            if self.timer.due_ns <= self._turns.next_ns:
                self._run_control(self.timer.due_ns)
            else:
                self.clock.sleep_until_ns(self._turns.next_ns)
            ticks = len(self.ticks.t_ns)
            self._turns.turn()
            if len(self.ticks.t_ns) > ticks:  # every order wakes the process, also one that came while a call was late
                self._turns.wake()

    def _run_control(self, until_ns: int) -> None:
        """Let time pass for everything but the driver's process."""
        while self.timer.due_ns <= until_ns:
            self._tick(self.timer.wait())
            self.timer.schedule()
        self.clock.sleep_until_ns(until_ns)

    def _tick(self, now_ns: int) -> None:
        leases = self.operator.leases
        samples = self.operator.arrived(now_ns)
        snapshot = self._driven.cycle(now_ns, leases.status(now_ns), samples, self._requests(now_ns))
        self.ticks.append(now_ns, snapshot, self._driven.report.fault)

    def _requests(self, now_ns: int) -> list[SessionRequest]:
        """From time to time the lease's holder resets the arm and asks to engage."""
        lease = self.operator.leases.current(now_ns)
        if (self.ticks.states and self.ticks.states[-1] in FOLLOWING) or now_ns < self._ask_ns or lease is None:
            return []
        self._ask_ns = now_ns + ASK_NS + round(self._rng.uniform(0, 500) * NS_PER_MS)
        actions = (EngagementAction.RESET, EngagementAction.ENGAGE)
        return [SessionRequest(action, lease.holder.name, seen_ns=self.ticks.halted_ns) for action in actions]

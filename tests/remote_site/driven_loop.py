"""The remote loop with the driver process in between: pipeline, supervisor, and a robot that may be misread."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from common.clock import NS_PER_MS, FakeClock
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from lab.stage.stepped.driver_process import SteppedDriverProcess
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import GripperReading, JointCommand, RobotReading
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.session.config import EngagementConfig, EngagementMode
from remote_site.session.lease import Holder, Lease, LeaseServer
from remote_site.session.requests import SessionRequest
from remote_site.session.samples import NamedSample
from remote_site.session.state_machine import Answer
from remote_site.teleop.cycle import Snapshot
from tests.remote_site.remote_loop import FOR_EVER_NS, LEASE, START_NS, TICK_NS, hand

CONFIG = RemoteConfig(engagement=EngagementConfig(mode=EngagementMode.ON_REQUEST, frames=8))
TICKS_PER_SAMPLE = 8
Spoil = Callable[[RobotReading], object]


class MisreadRobot(KinematicDriver):
    """A kinematic robot with a gripper, whose readings a test can spoil; it keeps what was written and activated."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self.spoil: Spoil | None = None
        self.written: list[JointCommand] = []
        self.activated: list[np.ndarray] = []

    def activate(self, q0: np.ndarray) -> None:
        super().activate(q0)
        self.activated.append(np.array(q0))

    def read(self) -> RobotReading:
        reading = replace(super().read(), gripper=GripperReading(0.05, 1.0))
        return reading if self.spoil is None else self.spoil(reading)  # type: ignore[return-value]  # as a driver may

    def write(self, command: JointCommand) -> JointCommand:
        self.written.append(command)
        return super().write(command)

    @property
    def finite(self) -> bool:
        """Whether every motion that reached the robot was."""
        return all(c.motion.finite for c in self.written) and all(np.isfinite(q).all() for q in self.activated)


class DrivenLoop:
    """Control and the driver's process on stepped time, a turn of the latter every 2 ms."""

    def __init__(self) -> None:
        self.clock = FakeClock(START_NS)
        self.robot = MisreadRobot(self.clock)
        self.process = SteppedDriverProcess(CONFIG, self.robot, self.clock)
        self.supervisor, self.link = self.process.supervisor, self.process.link
        self.leases = LeaseServer(FOR_EVER_NS, LEASE)
        granted = self.leases.acquire(Holder(7, "operator-7"), self.clock.now_ns())
        assert isinstance(granted, Lease)
        self.driven = self.process.pipeline()
        self.snapshot: Snapshot
        self._ticks = self._seq = 0

    @property
    def state(self) -> SessionState:
        """The session's state."""
        return self.snapshot.state

    def start(self) -> None:
        """Activate where the configuration has the arm, and follow a hand at rest."""
        self.link.activate(CONFIG.robot.start)
        self.run(80)
        assert self.ask(EngagementAction.ENGAGE).done
        self.run(20)
        assert self.state is SessionState.ENGAGED

    def tick(self, *requests: EngagementAction, speed_m_s: float = 0.0) -> None:
        """One tick of control, with a hand that moves at this speed since the start."""
        for _ in range(2):
            self.clock.advance_ms(TICK_NS / 2 / NS_PER_MS)
            self.process.turn()
        self._ticks += 1
        samples = []
        if self._ticks % TICKS_PER_SAMPLE == 0:
            self._seq += 1
            self._hand_m = getattr(self, "_hand_m", 0.0) + speed_m_s * TICKS_PER_SAMPLE * TICK_NS / 1e9
            sample = hand(self._seq, self.clock.now_ns(), (self._hand_m, 0.0, 0.3))
            samples.append(NamedSample("operator-7", sample))
        seen_ns = self.snapshot.halted_ns if self._ticks > 1 else 0
        asked = [SessionRequest(action, "operator-7", seen_ns=seen_ns) for action in requests]
        now_ns = self.clock.now_ns()
        self.snapshot = self.driven.cycle(now_ns, self.leases.status(now_ns), samples, asked)

    def run(self, ticks: int, speed_m_s: float = 0.0) -> None:
        for _ in range(ticks):
            self.tick(speed_m_s=speed_m_s)

    def ask(self, action: EngagementAction) -> Answer:
        """One tick with a request of the lease's holder, and what is answered."""
        self.tick(action)
        return self.snapshot.answers[0]

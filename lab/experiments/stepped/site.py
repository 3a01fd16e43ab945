"""The remote site on stepped time: robot, driver, supervisor and pipeline, each at its own rate."""

from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

from common.clock import NS_PER_S, Clock, FakeClock
from common.errors import ProcessError
from common.geometry import Array
from common.messages.requests import Description
from common.messages.robot import GripperState
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.drivers.driver import Driver, DriverSetup
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.supervisor.grip import GripWatch
from remote_site.drivers.supervisor.supervisor import DriverSupervisor
from remote_site.kinematics.limits import load_arm
from remote_site.runtime.driven_pipeline import DrivenPipeline
from remote_site.runtime.driver_process import DriverLoop, grip_settings, setup_of
from remote_site.runtime.request_server import describe
from remote_site.session.lease import Holder, Lease, LeaseStatus
from remote_site.session.samples import NamedSample
from remote_site.teleop.cycle import Snapshot
from remote_site.teleop.pipeline import TeleopPipeline

BEGIN_NS = NS_PER_S  # not 0: that stands for no sample
ACTIVATION_NS = NS_PER_S
OPERATOR, SESSION, LEASE = "operator", 1, 1
FOR_EVER_NS = 3600 * NS_PER_S


class Every:
    """Is due once in each period, from a first time on."""

    def __init__(self, period_ns: int, first_ns: int) -> None:
        self._period_ns, self._next_ns = period_ns, first_ns

    def due(self, now_ns: int) -> bool:
        """Return whether it is due now; then the next is a period later."""
        is_due = now_ns >= self._next_ns
        self._next_ns += self._period_ns if is_due else 0
        return is_due


class SteppedRobot(Protocol):
    """A robot whose own time advances with each step of `dt_s`; `q` (n,) in rad is where its joints truly are."""

    dt_s: float

    @property
    def q(self) -> Array: ...

    def driver(self, clock: Clock) -> Driver: ...

    def step(self, now_ns: int) -> None: ...


R = TypeVar("R", bound=SteppedRobot)


class SteppedClock(FakeClock):
    """A fake clock that steps the robot, and then what is set as `after_step`, as its time advances."""

    def __init__(self, robot: SteppedRobot) -> None:
        super().__init__(BEGIN_NS)
        self._robot, self._step_ns = robot, round(robot.dt_s * NS_PER_S)
        self.after_step: Callable[[], None] = lambda: None

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """Advance to a time, ns, by all whole steps of the robot until then."""
        while self.time_ns + self._step_ns <= deadline_ns:
            self.time_ns += self._step_ns
            self._robot.step(self.time_ns)
            self.after_step()


class SteppedSite(Generic[R]):
    """The remote site around a robot, from BEGIN_NS on: what its processes do in real time, one after the other.

    `snapshot` is the pipeline's after the last tick. ProcessError when the driver does not activate the robot.
    """

    def __init__(self, config: RemoteConfig, robot: R) -> None:
        self.robot = robot
        self.model, limits = load_arm(config.robot)
        self.clock = SteppedClock(robot)
        self.description: Description = describe(config, self.model, limits)
        shared = DriverMemory.create(len(config.robot.start_deg))
        setup = setup_of(config)
        self._link = DriverLink(shared, limits, self.clock)
        self._run_driver(config, setup, robot.driver(self.clock), shared)
        self._activate()
        self._driven = DrivenPipeline(TeleopPipeline(config, self.model, limits), self._link)
        self._tick_ns = round(NS_PER_S / config.control.rate_hz)
        self._lease = LeaseStatus(Lease(LEASE, Holder(SESSION, OPERATOR), FOR_EVER_NS))
        self.snapshot = self.tick(())

    def tick(self, samples: Sequence[NamedSample], markers: Sequence[MarkerSighting] = ()) -> Snapshot:
        """One control period later, with the samples that arrived in it, and what was newly seen of markers."""
        self.clock.sleep_until_ns(self.clock.now_ns() + self._tick_ns)
        self.snapshot = self._driven.cycle(self.clock.now_ns(), self._lease, samples, markers=markers)
        return self.snapshot

    @property
    def now_ns(self) -> int:
        return self.clock.now_ns()

    @property
    def gripper(self) -> GripperState | None:
        """The gripper as the state publishes it."""
        return self._driven.report.gripper

    def _run_driver(self, config: RemoteConfig, setup: DriverSetup, driver: Driver, shared: DriverMemory) -> None:
        driver.configure(setup)
        supervisor = DriverSupervisor(driver, setup, self.clock, shared.busy, GripWatch(grip_settings(config)))
        self.clock.after_step = DriverLoop(supervisor, shared, self.clock).turn

    def _activate(self) -> None:
        end_ns, asked = self.clock.now_ns() + ACTIVATION_NS, False
        while not (asked and self._link.read().ready):
            self.clock.sleep_until_ns(self.clock.now_ns() + NS_PER_S // 100)
            report = self._link.read()
            if report.measured and not asked:
                self._link.activate(report.q)
                asked = True
            if self.clock.now_ns() > end_ns:
                raise ProcessError(f"the robot did not get ready: {report.fault}")

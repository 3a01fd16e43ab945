"""The remote site on stepped time: robot, driver, supervisor and pipeline, each at its own rate."""

from collections.abc import Sequence
from typing import Generic, TypeVar

from common.clock import NS_PER_S
from common.errors import ProcessError
from common.messages.requests import Description
from common.messages.robot import GripperState
from lab.stage.stepped.driver_process import SteppedDriverProcess
from lab.stage.stepped.robots import SteppedClock, SteppedRobot
from remote_site.assist.sighting import MarkerSighting
from remote_site.config import RemoteConfig
from remote_site.runtime.request_server import describe
from remote_site.session.lease import Holder, Lease, LeaseStatus
from remote_site.session.samples import NamedSample
from remote_site.teleop.cycle import Snapshot

ACTIVATION_NS = NS_PER_S
OPERATOR, SESSION, LEASE = "operator", 1, 1
FOR_EVER_NS = 3600 * NS_PER_S

R = TypeVar("R", bound=SteppedRobot)


class Every:
    """Is due once in each period, from a first time on."""

    def __init__(self, period_ns: int, first_ns: int) -> None:
        self._period_ns, self._next_ns = period_ns, first_ns

    def due(self, now_ns: int) -> bool:
        """Return whether it is due now; then the next is a period later."""
        is_due = now_ns >= self._next_ns
        self._next_ns += self._period_ns if is_due else 0
        return is_due


class SteppedSite(Generic[R]):
    """The remote site around a robot, from BEGIN_NS on: what its processes do in real time, one after the other.

    `snapshot` is the pipeline's after the last tick. ProcessError when the driver does not activate the robot.
    """

    def __init__(self, config: RemoteConfig, robot: R) -> None:
        self.robot = robot
        self.clock = SteppedClock(robot)
        process = SteppedDriverProcess(config, robot.driver(self.clock), self.clock)
        self.model, self._link = process.model, process.link
        self.description: Description = describe(config, process.model, process.limits)
        self.clock.after_step = process.turn
        self._activate()
        self._driven = process.pipeline()
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

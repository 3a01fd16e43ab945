"""A stand on a machine that stands still now and then, on a clock moved by hand."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from common.clock import NS_PER_MS, FakeClock
from remote_site.drivers.conformance.machine_pauses import MachineTimes, PauseMeter
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.driver import Driver, RobotReading
from remote_site.drivers.kinematic import KinematicDriver
from tests.contracts.driver_stands import CONFIG, SETUP


class BusyMachine(FakeClock):
    """Its own clock, and its own meter; `pauses` is how often it will still stand still, for `pause_ms` each time.

    It does when asked to, and after each `sleeps`, where that is given.
    """

    def __init__(self, pauses: int, pause_ms: float = 60.0, sleeps: int | None = None) -> None:
        super().__init__(NS_PER_MS * 1000)
        self.pauses, self.pause_ms, self.queued_ns, self.trials = pauses, pause_ms, 0, 0
        self._sleeps, self._slept = sleeps, 0

    def sleep_until_ns(self, deadline_ns: int) -> None:
        super().sleep_until_ns(deadline_ns)
        self._slept += 1
        if self._sleeps is not None and self._slept % self._sleeps == 0:
            self.stand_still()

    def stand_still(self) -> None:
        """Pause once, if any pause is left."""
        if self.pauses:
            self.pauses -= 1
            self.advance_ms(self.pause_ms)
            self.queued_ns += round(self.pause_ms * NS_PER_MS)

    def read(self) -> MachineTimes:
        return MachineTimes(queued_ns=self.queued_ns)

    @contextmanager
    def measure(self) -> Iterator[PauseMeter]:
        self.trials += 1
        yield self


class Interrupted(KinematicDriver):
    """A good driver, in one call of which in a hundred the machine stands still."""

    own_ms = 0.0  # what that call takes of itself

    def __init__(self, machine: BusyMachine) -> None:
        super().__init__(machine)
        self._machine, self._reads = machine, 0

    def read(self) -> RobotReading:
        self._reads += self._obeyed is not None
        if self._reads % 100 == 50:
            self._machine.advance_ms(self.own_ms)
            self._machine.stand_still()
        return super().read()


def busy_stand(machine: BusyMachine, make: Callable[[BusyMachine], Driver] = Interrupted) -> DriverStand:
    """The kinematic arm on that machine."""
    return DriverStand(machine, SETUP, lambda: make(machine), CONFIG.robot.start, machine.measure)

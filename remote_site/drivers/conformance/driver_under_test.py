"""The driver under test: names the call that raises, returns the wrong type, is slow or never returns."""

from collections.abc import Callable
from typing import TypeVar

from common.clock import NS_PER_S
from common.errors import DriverError
from common.geometry import Array
from common.host_clock import MonotonicClock
from remote_site.drivers.conformance.call_watch import CallWatch
from remote_site.drivers.driver import Capabilities, Driver, DriverSetup, JointCommand, RobotReading

T = TypeVar("T")


class CallMonitor:
    """The driver's call that is running; other threads may read it."""

    def __init__(self) -> None:
        self._clock = MonotonicClock()  # a call hangs in real time, whatever the trial's clock
        self._begun: tuple[str, int] | None = None
        self._given_up = False
        self.raised = ""

    def call(self, name: str, call: Callable[[], T]) -> T:
        """Make a call and return its result; `raised` is its name when it raises anything but a DriverError."""
        if self._given_up:
            raise SystemExit  # ends the thread: no more calls may reach a robot without supervision
        self._begun, self.raised = (name, self._clock.now_ns()), ""
        try:
            return call()
        except DriverError:
            raise
        except BaseException:
            self.raised = name
            raise
        finally:
            self._begun = None

    def stuck(self, limit_s: float) -> str:
        """The call that has lasted longer than `limit_s`, "" without one."""
        begun = self._begun
        return begun[0] if begun is not None and self._clock.now_ns() - begun[1] > limit_s * NS_PER_S else ""

    def give_up(self) -> None:
        """Make no further call."""
        self._given_up = True


class DriverUnderTest:
    """A `Driver` that passes every call on to the one under test, and times those that come while the robot runs."""

    def __init__(self, make: Callable[[], Driver], monitor: CallMonitor, watch: CallWatch) -> None:
        self._monitor, self._watch = monitor, watch
        self._driver = monitor.call("its construction", make)
        self._joints: int | None = None

    @property
    def capabilities(self) -> Capabilities:
        """The driver's own."""
        return self._monitor.call("capabilities", lambda: _of(Capabilities, self._driver.capabilities))

    def configure(self, setup: DriverSetup) -> None:
        """Note how many joints are to be read."""
        self._monitor.call("configure", lambda: self._driver.configure(setup))
        self._joints = len(setup.joint_names)

    def activate(self, q0: Array) -> None:
        """Activate the driver."""
        self._timed("activate", lambda: self._driver.activate(q0))

    def read(self) -> RobotReading:
        """A reading with as many joints as the model has."""
        return self._timed("read", self._read)

    def write(self, command: JointCommand) -> JointCommand:
        """Pass a command on."""
        return self._timed("write", lambda: _of(JointCommand, self._driver.write(command)))

    def stop(self) -> None:
        """Stop the driver."""
        self._timed("stop", self._driver.stop)

    def deactivate(self) -> None:
        """End the driver."""
        self._monitor.call("deactivate", self._driver.deactivate)

    def _timed(self, name: str, call: Callable[[], T]) -> T:
        return self._monitor.call(name, lambda: self._watch.call(name, call))

    def _read(self) -> RobotReading:
        reading = _of(RobotReading, self._driver.read())
        shapes = {reading.q.shape, reading.dq.shape}
        if self._joints is not None and shapes != {(self._joints,)}:
            raise TypeError(f"q and dq have {self._joints} joints, not the shapes {shapes}")
        return reading


def _of(kind: type[T], given: object) -> T:
    if not isinstance(given, kind):
        raise TypeError(f"it returned {given!r}, not a {kind.__name__}")
    return given

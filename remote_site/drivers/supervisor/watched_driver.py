"""A driver whose calls are marked for other processes and timed against their deadline; failures become faults."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from common.clock import NS_PER_MS, Clock
from common.errors import DriverError
from common.geometry import Array
from common.text import cut
from remote_site.drivers.driver import Driver, JointCommand, RobotReading
from remote_site.drivers.faults import MOST_SENTENCE, FaultCode, RobotFault
from remote_site.drivers.supervisor.reading_check import ReadingCheck

DEADLINE_NS = 50 * NS_PER_MS

T = TypeVar("T")


class CallMark(Protocol):
    """Shows other processes when the driver call under way began, in ns; 0 between calls."""

    def set(self, since_ns: int) -> None: ...


class WatchedDriver:
    """The calls of a driver that the supervisor makes; each returns a RobotFault when it raises or takes too long.

    A DriverError becomes a fault REFUSED, anything else that is raised DRIVER, more than 50 ms DEADLINE. A reading
    passes `readings` first.
    """

    def __init__(self, driver: Driver, clock: Clock, mark: CallMark, readings: ReadingCheck) -> None:
        self._driver, self._clock, self._mark, self._readings = driver, clock, mark, readings

    def activate(self, q0: Array) -> RobotFault | None:
        """Ask the robot to take commands from rest at `q0`."""
        self._readings.restart()
        return self._call("activate", lambda: self._driver.activate(q0))

    def read(self) -> RobotReading | RobotFault:
        """Read the robot; the fault of a reading that cannot be true."""
        return self._call("read", lambda: self._readings.judge(self._driver.read(), self._clock.now_ns()))

    def write(self, command: JointCommand) -> RobotFault | None:
        """Hand a checked motion to the robot."""
        sent = self._call("write", lambda: self._driver.write(command))
        if isinstance(sent, RobotFault):
            return sent
        if isinstance(sent, JointCommand):
            return None
        wrong = f"the driver's write returned {type(sent).__name__}, not the JointCommand that was sent"
        return RobotFault(FaultCode.DRIVER, f"{wrong}; correct the driver")

    def stop(self) -> RobotFault | None:
        """Let the robot stop by itself."""
        return self._call("stop", self._driver.stop)

    def stop_after(self, fault: RobotFault) -> RobotFault:
        """Let the robot stop by itself; the fault, and that it does not stop if that fails too."""
        failed = self.stop()
        if failed is None:
            return fault
        first = cut(fault.sentence, MOST_SENTENCE // 2)  # a long one must not hide the second
        return RobotFault(fault.code, f"{first}; nor does it stop: {failed.sentence}")

    def _call(self, name: str, call: Callable[[], T]) -> T | RobotFault:
        begin_ns = self._clock.now_ns()
        self._mark.set(begin_ns)
        try:
            result = call()
        except DriverError as error:
            return RobotFault(FaultCode.REFUSED, _said(error))
        except BaseException as error:  # an installed driver may raise anything, and a robot's library may exit
            raised = f"the driver's {name} raised {type(error).__name__}"
            return RobotFault(FaultCode.DRIVER, f"{raised}: {_said(error)}")
        finally:
            self._mark.set(0)
        took_ns = self._clock.now_ns() - begin_ns
        return late_call(name, took_ns) if took_ns > DEADLINE_NS else result


def _said(error: BaseException) -> str:
    try:
        return str(error)
    except Exception:  # its text is the driver's code, too
        return "(its text cannot be read)"


def late_call(name: str, took_ns: int) -> RobotFault:
    """The fault of a call that exceeds the deadline."""
    limit = f"limit {DEADLINE_NS / NS_PER_MS:.0f} ms"
    return RobotFault(FaultCode.DEADLINE, f"the driver's {name} took {took_ns / NS_PER_MS:.0f} ms ({limit})")

"""The calls of an arm whose methods wait for the robot, made by a thread: the driver's process does not wait."""

import threading
from collections.abc import Callable
from functools import partial

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.position_arm.calls import ArmCalls, Measurement

STOP_WAIT_S = 0.03  # a call of the driver has 50 ms
END_WAIT_S = 0.5
STUCK_NS = 100 * NS_PER_MS
RETRY_NS = 10 * NS_PER_MS


class ThreadedCalls:
    """`Calls` made one at a time by one thread: a stop first, then the newest command, then a reading.

    A stop waits for the call under way, since few libraries may be called twice at once. The thread begins with the
    first of the calls here, with the priority of the thread that makes it. What it raises is raised by the next
    `measure`, and what a command raises by the next `write` too.
    """

    def __init__(self, calls: ArmCalls, clock: Clock) -> None:
        self._calls, self._clock = calls, clock
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None
        self._command: JointCommand | None = None
        self._measurement: Measurement | None = None
        self._error: BaseException | None = None
        self._unwritten: BaseException | None = None
        self._stops = self._ends = False

    @property
    def obeyed(self) -> int | None:
        """The number of the last command that the thread has written."""
        return self._calls.obeyed

    @property
    def sent(self) -> Array | None:
        """The positions to which the thread has sent the arm last."""
        return self._calls.sent

    def begin(self, q: Array, hang: Array, most_rad: Array, most_n: float) -> None:
        """Nothing has been commanded; DriverError while a stop has not reached the arm."""
        with self._changed:
            if self._stops:
                raise DriverError(f"the arm has not been stopped yet; {self._waits_for()}")
            self._unwritten = None
            self._calls.begin(q, hang, most_rad, most_n)

    def measure(self) -> Measurement | None:
        """Return what the thread has read since the last call; raise what it has met."""
        self._start()
        with self._changed:
            self._raise_error()
            measurement, self._measurement = self._measurement, None
            return measurement

    def write(self, command: JointCommand) -> None:
        """Leave a command for the thread, in the place of one that it has not taken; raises what the last one has."""
        self._start()
        with self._changed:
            error, self._unwritten = self._unwritten, None
            if error is not None:
                raise error
            self._command = command
            self._calls.note_grip(command)
            self._changed.notify_all()

    def withdraw_grip(self) -> None:
        """Forget what the gripper was ordered, also where the thread waits for the arm before it comes to that."""
        self._calls.withdraw_grip()

    def stop(self) -> None:
        """Have the arm stopped; DriverError where a call has been under way for so long that it may never return."""
        self._start()
        self.withdraw_grip()
        with self._changed:
            self._command, self._error, self._stops = None, None, True
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._error is not None or not self._stops, STOP_WAIT_S)
            if self._stops:
                self._raise_error()
            if self._stops and self._stuck():
                raise DriverError(self._waits_for())

    def end(self, *, stops: bool) -> None:
        """Let the thread stop the arm, let go of it, and end; DriverError if it does not come to that."""
        if self._thread is None:
            self._calls.end(stops=stops)
            return
        self.withdraw_grip()
        with self._changed:
            self._command, self._stops, self._ends = None, self._stops or stops, True
            self._changed.notify_all()
        self._thread.join(END_WAIT_S)
        if self._thread.is_alive():
            raise DriverError(self._waits_for())
        self._raise_error()

    def _start(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="arm", daemon=True)
            self._thread.start()

    def _stuck(self) -> bool:
        call = self._calls.under_way
        return call is not None and self._clock.now_ns() - call[1] > STUCK_NS

    def _waits_for(self) -> str:
        call = self._calls.under_way
        if call is None:
            return "the thread that calls it is late"
        return f"{call[0]} has not returned for {(self._clock.now_ns() - call[1]) / NS_PER_MS:.0f} ms"

    def _raise_error(self) -> None:
        error, self._error = self._error, None
        if error is not None:
            raise error

    def _run(self) -> None:
        while not self._ends:
            with self._changed:
                self._changed.wait_for(self._asked, self._idle_s())
                command, self._command = self._command, None
            if not self._succeeds(partial(self._turn, command)):
                self._clock.sleep_until_ns(self._clock.now_ns() + RETRY_NS)
        self._error = None  # what was met before the end is no failure of it
        self._succeeds(partial(self._calls.end, stops=self._stops))

    def _succeeds(self, call: Callable[[], None]) -> bool:
        """Make a call and return whether it raised nothing; otherwise what it raised is kept."""
        try:
            call()
        except BaseException as error:  # a robot's library may raise anything, and exit
            with self._changed:
                self._error = error
                self._changed.notify_all()
            return False
        return True

    def _turn(self, command: JointCommand | None) -> None:
        if self._stops:
            self._calls.stop()
            with self._changed:
                self._stops = False
                self._changed.notify_all()
        elif command is not None:
            self._write(command)
        measurement = self._calls.measure()
        if measurement is not None:
            with self._changed:
                self._measurement = measurement

    def _write(self, command: JointCommand) -> None:
        try:
            self._calls.send(command)
        except BaseException as error:
            self._unwritten = error
            raise

    def _asked(self) -> bool:
        return self._stops or self._ends or self._command is not None

    def _idle_s(self) -> float:
        return max(self._calls.due_ns - self._clock.now_ns(), 0) / NS_PER_S

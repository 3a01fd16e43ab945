"""A trial of a driver: it is activated, moved by small angles and along its first joint; every call is timed."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.call_watch import CallWatch
from remote_site.drivers.conformance.driver_under_test import CallMonitor, DriverUnderTest
from remote_site.drivers.conformance.joint_sentences import positions, unlike_in_sign, wrong_way
from remote_site.drivers.conformance.machine_pauses import MeasurePauses, no_pauses
from remote_site.drivers.driver import Driver, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import FaultCode
from remote_site.drivers.supervisor.grip import GripSettings, GripWatch
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.drivers.supervisor.state import ACTIVE, SupervisorState
from remote_site.drivers.supervisor.supervisor import APART_RAD, DriverSupervisor
from remote_site.kinematics.joints import JointMotion
from remote_site.motion.jerk_limited import JerkLimitedTracker

READY_MS = 5000
STEP_MS = 2
WINDOW_MS = 150
SPEED_RAD_S = 0.8
STROKE_RAD = 0.7
JOG_RAD = 0.1
JOG_MORE_RAD = 0.025  # each joint moves this much more than the one before it, so that no two can be confused


class Failed(Exception):  # noqa: N818  # a check's verdict, not an error of the program
    """The verdict that a driver does something wrong, and what."""


class Hopeless(Failed):
    """A failure that every other check would repeat."""


class TooSlow(Failed):
    """Calls that took too long, and nothing else."""


class Interrupted(Exception):  # noqa: N818  # a person's wish, not an error of the program
    """A person wants the suite to end."""


class Skipped(Exception):  # noqa: N818  # a check's verdict, not an error of the program
    """The verdict that a check does not apply to this driver, and why."""


def as_sentence(call: str, error: BaseException) -> str:
    """A sentence for what a call has raised."""
    if isinstance(error, DriverError):
        return f"{call} is refused: {error}"
    return f"{call} raised {type(error).__name__}: {error}"


def never() -> bool:
    """Nobody ends this suite before its time."""
    return False


@dataclass(frozen=True, slots=True)
class DriverStand:
    """A test stand: its clock, what makes a driver, and the posture in which the robot starts.

    `measure_pauses` is for a clock of real time, so that pauses of the machine are not taken for the driver's.
    `call_clock` times the calls where the stand's clock is a simulator's, which may be slower than they are.
    `should_stop` says that a person wants the suite to end.
    """

    clock: Clock
    setup: DriverSetup
    make: Callable[[], Driver]
    start: Array
    measure_pauses: MeasurePauses = no_pauses
    call_clock: Clock | None = None
    should_stop: Callable[[], bool] = never


class NoMark:
    """The mark of a call that no other process looks at."""

    def set(self, since_ns: int) -> None:
        """Nothing; the calls of a driver under test are timed by `CallWatch`."""


def gentle(setup: DriverSetup) -> DriverSetup:
    """The same limits, slowed until the first joint moves at 0.8 rad/s at most."""
    fastest = float(setup.limits.velocity[0])
    return replace(setup, limits=setup.limits.scaled_speed(min(1.0, SPEED_RAD_S / fastest)))


class Trial:
    """One driver, from construction to deactivation, behind the supervisor that its process has."""

    def __init__(self, stand: DriverStand, monitor: CallMonitor, watch: CallWatch) -> None:
        self._stand, self.watch = stand, watch
        self.setup = gentle(stand.setup)
        self.driver = DriverUnderTest(stand.make, monitor, watch)
        self.supervisor = DriverSupervisor(self.driver, self.setup, stand.clock, NoMark(), GripWatch(GripSettings()))
        self.log: list[RobotReading] = []
        self.commanded: list[tuple[int, Array]] = []  # time in ns and joints at each reading of the log
        self._should_stop = stand.should_stop
        self._way = stand.start, stand.start  # of the last motion that was commanded, from and to
        self._activation = self._seq = 0
        self.side = 1.0

    @property
    def clock(self) -> Clock:
        """The stand's clock."""
        return self._stand.clock

    @property
    def lag_ms(self) -> float:
        """The longest that the robot may take after a command to be where it was sent, ms."""
        return 1000 * self.driver.capabilities.longest_lag_s + 50

    @property
    def ready(self) -> bool:
        """The robot takes commands."""
        return self.supervisor.state in ACTIVE

    @property
    def first_joint(self) -> str:
        """The name of the joint that is moved at speed."""
        return self.setup.joint_names[0]

    @property
    def q0(self) -> Array:
        """The measured posture of the robot."""
        return self.log[-1].q if self.log else self._stand.start

    def configured(self) -> "Trial":
        """The same, configured, with a first reading where the driver has one before it is activated."""
        self.configure()
        self.run(300)
        self.turn_to_the_middle()
        return self

    def configure(self) -> None:
        """Configure the driver for the model that it is to move; Hopeless when it cannot be."""
        try:
            self.driver.configure(self.setup)
        except (Exception, SystemExit) as error:  # an installed driver may raise anything
            raise Hopeless(as_sentence("configure", error)) from error

    def turn_to_the_middle(self) -> None:
        """Move the first joint to the side where it has more room, from now on."""
        upper, lower = self.setup.limits.upper[0], self.setup.limits.lower[0]
        self.side = 1.0 if upper + lower >= 2 * self.q0[0] else -1.0

    def activated(self) -> "Trial":
        """The same, ready for commands in its posture."""
        self.configured()
        self.activate()
        return self

    def activate(self) -> None:
        """Activate, and wait until the robot is ready."""
        self._activation += 1
        given, zero = self.q0, np.zeros(len(self.q0))
        command = JointCommand(self._seq, self.clock.now_ns(), given, zero, zero, GripperCommand.KEEP)
        self.run(STEP_MS, [DriverOrder(self._activation, True, self.supervisor.commanded.stop_count, command)])
        for _ in range(READY_MS // STEP_MS):
            if self.supervisor.state is not SupervisorState.ACTIVATING:
                break
            self.run(STEP_MS)
        if not self.ready:
            kind = Hopeless if self._activation == 1 else Failed
            raise kind(self._not_ready(given))

    def run(self, ms: float, orders: list[DriverOrder] | None = None) -> None:
        """Let time pass, with the driver called as by its process; Interrupted when a person wants the end."""
        end_ns = self.clock.now_ns() + round(ms * NS_PER_MS)
        while self.clock.now_ns() < end_ns:
            if self._should_stop():
                raise Interrupted
            self.clock.sleep_until_ns(self.clock.now_ns() + STEP_MS * NS_PER_MS)
            self.supervisor.take(orders or [], self.clock.now_ns())
            orders = None
            self.supervisor.step(self.clock.now_ns())
            if self.supervisor.reading is not None:
                self.log.append(self.supervisor.reading)
                self.commanded.append((self.clock.now_ns(), self.supervisor.commanded.motion.q))
            self.watch.note_pause()

    def end(self) -> None:
        """Stop the robot, let it come to rest, and let go of it, also where a person has interrupted the check."""
        self._should_stop = never
        self.driver.stop()
        self.run(700)
        self.driver.deactivate()
        self.run(100)

    def move(self, target: Array, ms: float, gripper: GripperCommand = GripperCommand.KEEP) -> None:
        """Command motion to `target` for `ms`, and the gripper, one command a tick."""
        self._way = self.q0, target
        follower = JerkLimitedTracker(self.setup.limits, self.setup.dt)
        for _ in range(round(ms / 1000 / self.setup.dt)):
            follower.reset(self.supervisor.commanded.motion)
            motion = follower.track(JointMotion.at_rest(target))
            if not isinstance(motion, JointMotion):
                where = positions(self.setup.joint_names, target)
                raise Failed(f"no trajectory to {where}: {motion.sentence}")
            self.command(motion, gripper)

    def command(self, motion: JointMotion, gripper: GripperCommand = GripperCommand.KEEP) -> None:
        """One command and the tick after it; a late one continues from within the stop, as control does."""
        self._seq += 1
        now_ns, stop = self.clock.now_ns(), self.supervisor.commanded.stop
        if stop is not None:
            motion = stop.at(now_ns)
        command = JointCommand(self._seq, now_ns, motion.q, motion.dq, motion.ddq, gripper)
        self.run(
            self.setup.dt * 1000, [DriverOrder(self._activation, True, self.supervisor.commanded.stop_count, command)]
        )

    def in_motion(self) -> "Trial":
        """The same, its first joint at speed."""
        self.move(self.goal(STROKE_RAD), 500)
        self.must_be_ready()
        return self

    def must_be_ready(self) -> None:
        """Failed with its fault, and the joints that have moved the wrong way, if the robot takes no commands."""
        if not self.ready:
            wrong = self.wrong_way()
            stopped = f"it stopped: {self.supervisor.fault}"
            raise Failed(f"{wrong}; {stopped}" if wrong else stopped)

    def wrong_way(self) -> str:
        """Say which joints have gone the wrong way in the last motion; "" without one."""
        return wrong_way(self.setup.joint_names, *self._way, self.q0)

    def goal(self, ahead_rad: float) -> Array:
        """The posture with the first joint ahead by this angle."""
        target = self.q0.copy()
        target[0] += self.side * ahead_rad
        return target

    def jog(self) -> Array:
        """The posture with every joint off by an angle of its own to where it has more room, the first by the most."""
        upper, lower, q = self.setup.limits.upper, self.setup.limits.lower, self.q0
        ahead = np.append(STROKE_RAD / 2, JOG_RAD + JOG_MORE_RAD * np.arange(len(q) - 1))
        sides = np.where(upper + lower >= 2 * q, 1.0, -1.0)
        room: Array = np.where(sides > 0, upper - q, q - lower)
        jogged: Array = q + sides * np.minimum(ahead, room / 2)
        return jogged

    @property
    def last_seq(self) -> int:
        return self._seq

    def last(self) -> RobotReading:
        """The newest reading; Failed without one."""
        if not self.log:
            raise Failed(f"nothing can be read: {self.supervisor.fault}")
        return self.log[-1]

    def speed(self, window_ms: float = WINDOW_MS) -> float:
        """The first joint's mean speed over the last readings, rad/s."""
        last = self.last()
        since_ns = last.t_ns - round(window_ms * NS_PER_MS)
        first = next(reading for reading in self.log if reading.t_ns >= since_ns)
        seconds = (last.t_ns - first.t_ns) / NS_PER_S
        return abs(float(last.q[0] - first.q[0])) / seconds if seconds > 0 else 0.0

    def refuses(self, what: str, call: Callable[[], object]) -> None:
        """Failed unless the call raises DriverError."""
        try:
            call()
        except DriverError:
            return
        raise Failed(f"{what} raised nothing, where a DriverError is expected")

    def _not_ready(self, given: Array) -> str:
        """Say why the robot takes no commands after it was activated at `given` (n,) in rad."""
        fault, waited = self.supervisor.fault, self.supervisor.state is SupervisorState.ACTIVATING
        sentence = f"not ready {f'{READY_MS / 1000:g} s ' if waited else ''}after its activation: {fault}"
        if fault is None or fault.code is not FaultCode.APART:
            return sentence
        names, read = self.setup.joint_names, self.last().q
        if np.abs(read - given).max() <= APART_RAD:
            asks = "does activate send each joint with the sign, zero and unit of read?"
            return f"{sentence}; it was activated where it was read, at {positions(names, given)}: {asks}"
        unlike = unlike_in_sign(names, given, read)
        return f"{unlike}; {sentence}" if unlike else sentence

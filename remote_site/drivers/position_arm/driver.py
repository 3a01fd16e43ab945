"""The whole driver around an arm that takes positions: activation, speeds, stops, the time-out, and what it refuses."""

from dataclasses import dataclass, replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, DriverSetup, JointCommand, RobotReading, check_joints
from remote_site.drivers.faults import NOT_ACTIVATED, STILL_MOVING, STOPPED, RobotFault, apart
from remote_site.drivers.position_arm.arm import PositionArm, PositionArmWithGripper
from remote_site.drivers.position_arm.arm_stop import HeldPosture, WrittenStop
from remote_site.drivers.position_arm.calls import ArmCalls, Calls
from remote_site.drivers.position_arm.readings import ArmReadings
from remote_site.drivers.position_arm.threaded_calls import ThreadedCalls
from remote_site.drivers.supervisor.orders import command_timeout
from remote_site.safety.silence import Silence

# An arm at rest is activated where it was read just before. A position arm goes there in one step, so less is allowed
# than of other arms; an encoder of 4096 counts that flickers by several stays within it.
NEAR_RAD = 0.02
LONGEST_SPEED_MS = 500.0


@dataclass(frozen=True, slots=True)
class WrittenCommand:
    """A command, and when the arm was given it, ns."""

    command: JointCommand
    t_ns: int


class PositionArmDriver:
    """A `Driver` of a `PositionArm`; DriverError for attributes that no arm has.

    A reading has the positions as they were read, and the speeds of `SpeedOverWindow`; until these are known, `read`
    raises. It is stamped with the time just before `PositionArm.read`, or as the arm says, and keeps its stamp while
    the arm has nothing new. Nothing is written by an activation, and none moves the arm: it holds where it was sent
    last, and goes on from there, however far it hangs from that; but for joints that its own stop has braked. One that
    is read farther away than it can hang is not activated. `read`, which the driver's process calls in every turn, also
    stops the arm when nothing was written for the command time-out, and writes the positions of a stop.
    """

    def __init__(self, arm: PositionArm, clock: Clock) -> None:
        _check(arm)
        self._arm, self._clock = arm, clock
        self._capabilities = Capabilities(
            rate_hz=arm.rate_hz,
            joints=arm.joints,
            gripper=isinstance(arm, PositionArmWithGripper),
            force=False,
            watchdog_ms=None,
            lag_ms=arm.lag_ms,
            holds=True,
        )
        calls = ArmCalls(arm, clock)
        self._calls: Calls = ThreadedCalls(calls, clock) if arm.threaded else calls
        self._readings = ArmReadings(self._calls, arm.joints, round(arm.speed_over_ms * NS_PER_MS), clock)
        self._setup: DriverSetup | None = None
        self._silence = Silence(0)
        self._written: WrittenCommand | None = None  # in this activation
        self._stop: WrittenStop | None = None
        self._held = HeldPosture(arm.joints, self._capabilities.longest_lag_s, brakes=not arm.writes_stop)
        self._fault: RobotFault | None = NOT_ACTIVATED
        self._ended = False

    @property
    def capabilities(self) -> Capabilities:
        """As the arm declares; it has no watchdog that is known, and measures no force."""
        return self._capabilities

    def configure(self, setup: DriverSetup) -> None:
        """Configure the arm; DriverError if the model has another number of joints."""
        check_joints(setup, self._arm.joints)
        self._silence = Silence(setup.command_timeout_ns // 2)
        self._arm.configure(setup)
        self._setup = setup

    def activate(self, q0: Array) -> None:
        """Take commands from now on; DriverError unless the arm is read at rest and at `q0`. Nothing is written."""
        setup, reading = self._configured(), self.read()
        if self._stop is not None or reading.moving:
            raise DriverError(STILL_MOVING.sentence)
        if not np.abs(reading.q - q0).max() <= NEAR_RAD:
            raise DriverError(apart(setup.joint_names, q0.tolist(), reading.q.tolist()).sentence)
        most = setup.limits.velocity * (self._period_ns(setup) / NS_PER_S)
        sent = self._calls.sent
        hang = np.zeros(len(q0)) if sent is None else self._held.hang(setup.joint_names, sent, reading.q)
        self._calls.begin(q0, hang, most, setup.grip_force_n)
        self._written, self._fault = None, None

    def read(self) -> RobotReading:
        """The newest measurement; DriverError until there is one with speeds."""
        setup, now_ns = self._configured(), self._clock.now_ns()
        if self._ended:
            raise DriverError("the driver was deactivated, and measures nothing more")
        self._watch(setup, now_ns)
        self._write_stop(now_ns)
        return replace(self._readings.newest(), fault=self._fault, obeyed_seq=self._calls.obeyed)

    def write(self, command: JointCommand) -> JointCommand:
        """Send the arm to the command's positions; DriverError unless it is active."""
        if self._fault is not None:
            raise DriverError("activate the arm before it is commanded")
        self._calls.write(command)
        self._written = WrittenCommand(command, self._clock.now_ns())
        self._held.sent(command.motion, self._written.t_ns)
        return command

    def stop(self) -> None:
        """Stop the arm, by its own means or by writing; a stop that is being written goes on as it is."""
        if self._setup is not None and not self._ended and self._stop is None:
            self._begin_stop(self._setup, STOPPED)

    def deactivate(self) -> None:
        """Stop the arm, and let go of it."""
        if self._ended:
            return
        self._ended, self._fault = True, self._fault or STOPPED
        self._calls.end(stops=self._setup is not None)

    def _configured(self) -> DriverSetup:
        if self._setup is None:
            raise DriverError("configure the driver before the arm is used")
        return self._setup

    def _period_ns(self, setup: DriverSetup) -> int:
        """From one position to the next: a tick of control at least, whatever the arm could take."""
        return round(max(1.0 / self._arm.rate_hz, setup.dt) * NS_PER_S)

    def _watch(self, setup: DriverSetup, now_ns: int) -> None:
        """Stop an arm that nobody commands any more."""
        written, limit_ns = self._written, setup.command_timeout_ns
        silent_ns = self._silence.of(0 if written is None else written.t_ns, now_ns)
        if self._fault is None and written is not None and silent_ns > limit_ns:
            self._begin_stop(setup, command_timeout(silent_ns, limit_ns))

    def _begin_stop(self, setup: DriverSetup, why: RobotFault) -> None:
        written, was_active = self._written, self._fault is None
        self._fault = self._fault or why
        self._calls.withdraw_grip()
        if was_active and written is not None:
            self._held.stopped(written.command.motion, setup.limits, self._clock.now_ns())
        if self._arm.writes_stop and was_active and written is not None:
            motion, lag_s = written.command.motion, self._capabilities.longest_lag_s
            self._stop = WrittenStop(motion, setup.limits, written.t_ns, self._period_ns(setup), lag_s)
        else:
            self._calls.stop()

    def _write_stop(self, now_ns: int) -> None:
        """Write the stop that is under way; where that fails, or is at its end, the arm stops by its own means."""
        stop, written = self._stop, self._written
        if stop is None or written is None:
            return
        if stop.ended(now_ns):
            self._stop = None
            self._calls.stop()
            return
        q = stop.due(now_ns)
        if q is None:
            return
        try:
            self._calls.write(replace(written.command, q=q, gripper=GripperCommand.KEEP))
        except BaseException:
            self._stop = None
            self._calls.stop()
            raise


def _check(arm: PositionArm) -> None:
    """DriverError for attributes that no arm has; rate and lag are checked with the capabilities."""
    joints, window_ms = getattr(arm, "joints", None), arm.speed_over_ms
    if not (isinstance(joints, int) and joints > 0):
        raise DriverError(f"{type(arm).__name__}.joints is {joints}; give the number of joints that the arm has")
    if not 0 < window_ms <= LONGEST_SPEED_MS:
        raise DriverError(
            f"{type(arm).__name__}.speed_over_ms is {window_ms}; give more than 0, at most {LONGEST_SPEED_MS:g}"
        )

"""The driver of the A465's controller: setpoints at 15 Hz over a serial line, a halt on every fault, never limp."""

import math

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.c500c.config import C500cConfig
from remote_site.drivers.c500c.exchange import Exchange, is_up
from remote_site.drivers.c500c.port import Port
from remote_site.drivers.c500c.protocol import JOINTS, Activation, ControllerState, Fault, Flag, Kind, Setpoint
from remote_site.drivers.driver import (
    Capabilities,
    DriverSetup,
    GripperReading,
    JointCommand,
    RobotReading,
    check_joints,
)
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault

MOST_QUEUED = 2
WATCHDOG_MS = 200.0
ALPHA = 0.5  # of a new speed estimate: positions come 30 times a second, to a microradian
FAULTS = {
    Fault.WATCHDOG: (FaultCode.WATCHDOG, "nothing came over the line, the arm has halted"),
    Fault.UNDERRUN: (FaultCode.LINK, "the next setpoint came too late, the arm has halted"),
    Fault.APART: (FaultCode.APART, "the arm is not where it was activated; read it and activate there"),
    Fault.BLOCKED: (FaultCode.BLOCKED, "a joint is blocked, the arm has halted; clear its path"),
    Fault.EMERGENCY_STOP: (FaultCode.EMERGENCY_STOP, "the emergency stop is pressed; release it"),
    Fault.ARM_POWER: (FaultCode.ARM_POWER, "the arm has no power; switch it on"),
}


class C500cDriver:
    """A `Driver` that talks to the server program on the controller; no call waits for the line.

    Each call receives what has arrived and sends what is due, so it must be called a hundred times a second or more.
    The controller plays setpoints one period after the other and queues at most two.
    """

    def __init__(self, config: C500cConfig, port: Port, clock: Clock) -> None:
        self._config = config
        self._period_ms = math.ceil(1000 / config.rate_hz)
        self._exchange = Exchange(config, port)
        self._clock = clock
        self._setup: DriverSetup | None = None
        self._activation = -1  # none yet
        self._count = 0
        self._seqs: dict[int, int] = {}
        self._obeyed: int | None = None
        self._running = False
        self._closed_ns: int | None = None
        self._measured: tuple[int, Array, Array] | None = None

    @property
    def capabilities(self) -> Capabilities:
        """Six joints and a gripper whose force is not measured; a watchdog of its own, up to two periods queued."""
        return Capabilities(
            rate_hz=1000 / self._period_ms,
            joints=JOINTS,
            gripper=True,
            force=False,
            watchdog_ms=WATCHDOG_MS,
            queued_periods=MOST_QUEUED,
            holds=True,
        )

    def configure(self, setup: DriverSetup) -> None:
        """Check that the model has the arm's six joints."""
        check_joints(setup, JOINTS, "an A465")
        self._setup = setup

    def activate(self, q0: Array) -> None:
        """Ask the controller to take setpoints from rest at `q0`."""
        state = self._exchange.state
        if self._setup is None:
            raise DriverError("configure the c500c driver before it is activated")
        if state is None or self._silent:
            raise DriverError(self._silence().sentence)
        if not is_up(state):
            raise DriverError(FAULTS[_power_fault(state)][1])
        if Flag.MOVING in state.flags or not np.isfinite(q0).all():
            raise DriverError("the arm still moves; activate it when it rests")
        self._activation = (state.activation + 1) & 0xFFFF
        self._running, self._obeyed, self._seqs = True, None, {}
        activation = Activation(self._activation, tuple(q0.tolist()), self._period_ms)
        self._exchange.send(Kind.ACTIVATE, activation.payload)
        self._pump()

    def read(self) -> RobotReading:
        """The newest state received; DriverError before the first."""
        self._pump()
        state, measured = self._exchange.state, self._measured
        if state is None or measured is None:
            raise DriverError(self._silence().sentence)
        t_ns, q, dq = measured
        return RobotReading(t_ns, q, dq, GripperReading(state.opening_m, None), self._fault(state), self._obeyed)

    def write(self, command: JointCommand) -> JointCommand:
        """Send this setpoint as soon as the controller has room for it; DriverError before activation."""
        state = self._exchange.state
        if not self._running or state is None:
            raise DriverError(STOPPED.sentence if state is not None else NOT_ACTIVATED.sentence)
        self._count = (self._count + 1) & 0xFFFF
        self._seqs[self._count] = command.seq
        joints, percent = tuple(command.q.tolist()), self._grip_percent(command)
        self._exchange.send(Kind.SETPOINT, Setpoint(self._count, joints, command.gripper, percent).payload)
        self._pump()
        return command

    def stop(self) -> None:
        """Halt the arm: it brakes and holds, and stays powered."""
        if self._running or self._exchange.state is None:
            self._exchange.send(Kind.HALT)
        self._running = False
        self._pump()

    def deactivate(self) -> None:
        """Halt, and send no more setpoints."""
        self.stop()

    def _pump(self) -> None:
        exchange, before = self._exchange, self._exchange.received_ns
        exchange.pump(self._clock.now_ns())
        if exchange.state is not None and exchange.received_ns is not None and exchange.received_ns != before:
            self._note(exchange.state, exchange.received_ns)

    def _note(self, state: ControllerState, t_ns: int) -> None:
        q, dq = np.array(state.joints), np.zeros(JOINTS)
        if self._measured is not None:
            then_ns, before, rate = self._measured
            elapsed = (t_ns - then_ns) / NS_PER_S
            dq = ALPHA * (q - before) / elapsed + (1 - ALPHA) * rate if elapsed > 0 else rate
            dq = dq if Flag.MOVING in state.flags else np.zeros(JOINTS)
        self._measured = t_ns, q, dq
        if state.activation == self._activation and state.begun in self._seqs:
            self._obeyed = self._seqs[state.begun]
            self._seqs = {count: seq for count, seq in self._seqs.items() if seq >= self._obeyed}

    def _grip_percent(self, command: JointCommand) -> int:
        """Full force only for a limited time: above 75 % the gripper gets hot; no force with KEEP, which sends none."""
        config = self._config
        if command.gripper is GripperCommand.KEEP:
            return 0
        if command.gripper is GripperCommand.OPEN:
            self._closed_ns = None
            return config.grip_percent
        self._closed_ns = command.t_ns if self._closed_ns is None else self._closed_ns
        strong = command.t_ns - self._closed_ns < config.strong_grip_s * NS_PER_S
        return config.grip_percent if strong else min(config.grip_percent, config.hold_percent)

    @property
    def _silent(self) -> bool:
        received_ns = self._exchange.received_ns
        return received_ns is None or self._clock.now_ns() - received_ns > self._config.silent_ms * NS_PER_MS

    def _silence(self) -> RobotFault:
        return RobotFault(
            FaultCode.SILENT, "the controller does not answer; are its server program and the serial line up?"
        )

    def _fault(self, state: ControllerState) -> RobotFault | None:
        if self._silent:
            return self._silence()
        if not is_up(state):
            fault = _power_fault(state)
            return RobotFault(*FAULTS[fault], native=fault.name)
        if self._exchange.is_pending(Kind.ACTIVATE) or state.activation != self._activation:
            return NOT_ACTIVATED
        if Flag.ACTIVE in state.flags and self._running:
            return None
        return RobotFault(*FAULTS[state.fault], native=state.fault.name) if state.fault in FAULTS else STOPPED


def _power_fault(state: ControllerState) -> Fault:
    return Fault.EMERGENCY_STOP if Flag.EMERGENCY_STOP in state.flags else Fault.ARM_POWER

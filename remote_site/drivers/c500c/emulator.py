"""The A465's controller as Farhand expects it: server program, queue, watchdog, faults, gripper; 5 ms ticks; pure.

What it does is an assumption made from public descriptions; it was never compared with a real controller.
"""

import struct
from dataclasses import dataclass, field

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.c500c.playing import Player
from remote_site.drivers.c500c.protocol import Activation, ControllerState, Fault, Flag, Kind, ProtocolFrame, Setpoint
from remote_site.safety.stopping import JointStop, joint_stop

TICK_NS = 5 * NS_PER_MS
DT = TICK_NS / NS_PER_S
WATCHDOG_NS = 200 * NS_PER_MS
ACTIVATION_RAD = 0.02
STRONG_PERCENT, STRONG_S = 75, 15.0  # a stronger grip overheats the gripper, whoever has commanded it


@dataclass(frozen=True, slots=True)
class Emulated:
    """The emulated arm: its own braking, its gripper (m, m/s, s), and the object between the fingers, 0 for none."""

    brake_rad_s2: tuple[float, ...] = (10.0, 10.0, 10.0, 20.0, 20.0, 20.0)
    brake_jerk_rad_s3: float = 1000.0
    widest_m: float = 0.0508
    gripper_m_s: float = 0.1
    gripper_delay_s: float = 0.1
    object_m: float = 0.0


@dataclass
class _Gripper:
    emulated: Emulated
    opening_m: float
    aim_open: bool = True
    percent: int = 0
    delay_s: float = 0.0
    strong_s: float = 0.0

    def order(self, command: GripperCommand, percent: int) -> None:
        if command is GripperCommand.KEEP:
            return
        is_open = command is GripperCommand.OPEN
        if is_open is not self.aim_open:
            self.delay_s = self.emulated.gripper_delay_s
        self.aim_open, self.percent = is_open, percent

    def tick(self) -> None:
        self.delay_s = max(0.0, self.delay_s - DT)
        self.strong_s = self.strong_s + DT if self.percent > STRONG_PERCENT and not self.aim_open else 0.0
        if self.strong_s > STRONG_S:
            self.percent = STRONG_PERCENT
        if self.delay_s == 0.0:
            goal = self.emulated.widest_m if self.aim_open else self.emulated.object_m
            step = self.emulated.gripper_m_s * DT
            self.opening_m += min(max(goal - self.opening_m, -step), step)

    @property
    def busy(self) -> bool:
        goal = self.emulated.widest_m if self.aim_open else self.emulated.object_m
        return self.opening_m != goal


@dataclass
class _Brake:
    joints: list[JointStop]
    elapsed_s: float = 0.0


@dataclass
class EmulatedController:
    """Runs tick by tick: `receive` takes frames, `tick` returns the answers."""

    q: Array
    emulated: Emulated = field(default_factory=Emulated)
    emergency_stop: bool = False
    jammed: bool = False
    activation: int = 0
    arm_power: bool = True

    def __post_init__(self) -> None:
        self.player = Player(np.array(self.q, dtype=float), 1.0)
        self.gripper = _Gripper(self.emulated, self.emulated.widest_m)
        self.active, self.fault = False, Fault.NONE
        self._brake: _Brake | None = None
        self._received_ns: int | None = None
        self._frames: list[ProtocolFrame] = []
        self._last_setpoint: int | None = None

    @property
    def dq(self) -> Array:
        """Joint velocity, rad/s."""
        return self.player.dq

    @property
    def _cut(self) -> Fault:
        """The reason why the arm is without power, Fault.NONE when it has it."""
        if self.emergency_stop:
            return Fault.EMERGENCY_STOP
        return Fault.NONE if self.arm_power else Fault.ARM_POWER

    def receive(self, frames: list[ProtocolFrame], now_ns: int) -> None:
        """Take complete frames; they are handled in the next tick."""
        if frames:
            self._received_ns = now_ns
        self._frames += frames

    def tick(self, now_ns: int) -> bytes:
        """Advance by 5 ms, and answer every frame received."""
        answers = b""
        for frame in self._frames:
            self._obey(frame)
            answers += ProtocolFrame(frame.sequence, Kind.STATE, self._state().payload).encoded
        self._frames = []
        self._watch(now_ns)
        self._move()
        self.gripper.tick()
        return answers

    def halt(self, fault: Fault = Fault.NONE) -> None:
        """Brake and hold, powered, until an activation."""
        if self.active:
            self.fault = fault
        self.active = False
        self.player.queue.clear()
        if self._brake is None and self.dq.any():
            limits, states = self.emulated, zip(self.player.q.tolist(), self.dq.tolist(), strict=True)
            brakes = zip(states, limits.brake_rad_s2, strict=True)
            self._brake = _Brake([joint_stop((q, v, 0.0), a, limits.brake_jerk_rad_s3) for (q, v), a in brakes])

    def _obey(self, frame: ProtocolFrame) -> None:
        try:
            if frame.kind == Kind.SETPOINT:
                self._take(Setpoint.parse(frame.payload))
            elif frame.kind == Kind.ACTIVATE:
                self._activate(Activation.parse(frame.payload))
            elif frame.kind == Kind.HALT:
                self.halt()
        except (struct.error, ValueError):
            return  # not as its kind is built: answered as an unknown kind is, and not obeyed

    def _take(self, setpoint: Setpoint) -> None:
        if not self.active or setpoint.count == self._last_setpoint:
            return
        if self.player.add(setpoint.count, np.array(setpoint.joints)):
            self._last_setpoint = setpoint.count
            self.gripper.order(setpoint.gripper, setpoint.grip_percent)

    def _activate(self, activation: Activation) -> None:
        if activation.count == self.activation or self.dq.any() or self._cut:
            return
        self.activation, self.active = activation.count, False
        self.fault = Fault.NONE
        if np.abs(np.array(activation.joints) - self.player.q).max() > ACTIVATION_RAD:
            self.fault = Fault.APART
            return
        self.player = Player(self.player.q, activation.period_ms / 1000, begun=self.player.begun)
        self.active, self._last_setpoint = True, None

    def _watch(self, now_ns: int) -> None:
        if self._cut and (self.active or self.dq.any()):
            self.halt(self._cut)
            self._brake, self.player.dq = None, np.zeros(len(self.player.q))  # the holding brakes engage
        if self.jammed and self.dq.any():
            self.halt(Fault.BLOCKED)
        if self.active and self._received_ns is not None and now_ns - self._received_ns > WATCHDOG_NS:
            self.halt(Fault.WATCHDOG)

    def _move(self) -> None:
        if self._brake is not None:
            self._brake.elapsed_s += DT
            states = [joint.at(self._brake.elapsed_s) for joint in self._brake.joints]
            self.player.q, self.player.dq = np.array([s[0] for s in states]), np.array([s[1] for s in states])
            if not self.player.dq.any():
                self._brake = None
        elif self.active and not self.player.tick(DT):
            self.halt(Fault.UNDERRUN)

    def _state(self) -> ControllerState:
        flags = Flag(0)
        for flag, is_set in (
            (Flag.ACTIVE, self.active),
            (Flag.MOVING, bool(self.dq.any())),
            (Flag.ARM_POWER, not self._cut),
            (Flag.EMERGENCY_STOP, self.emergency_stop),
            (Flag.GRIPPER_BUSY, self.gripper.busy),
        ):
            flags |= flag if is_set else Flag(0)
        return ControllerState(
            flags,
            self.fault,
            len(self.player.queue),
            self.activation,
            self.player.begun,
            self._last_setpoint or 0,
            self.gripper.opening_m,
            tuple(self.player.q.tolist()),
        )

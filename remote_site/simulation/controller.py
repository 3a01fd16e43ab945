"""The simulated robot controller's decisions: which joint motion to follow now, and its own command watchdog; pure."""

import math
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import ModelError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.silence import Silence
from remote_site.safety.stopping import stopping
from remote_site.shared_record import Record
from remote_site.simulation.config import ServoConfig
from remote_site.simulation.memory import GRIPPER_COMMANDS, CellCommand


class ControllerFault(IntEnum):
    """The reasons why the controller takes no setpoints."""

    NONE = 0
    WATCHDOG = 1
    NOT_FINITE = 2
    APART = 3
    BLOCKED = 4


@dataclass(slots=True)
class SetpointWatch:
    """The setpoint obeyed last, its time, and the watchdog of their arrival; `obeyed_ns` is 0 before the first."""

    timeout_ns: int
    seq: int = -1
    obeyed_seq: int = 0
    obeyed_ns: int = 0
    _silence: Silence = field(init=False)

    def __post_init__(self) -> None:
        self._silence = Silence(self.timeout_ns // 2)

    def obey(self, seq: int, now_ns: int) -> None:
        """Take a new setpoint."""
        self.seq = self.obeyed_seq = seq
        self.obeyed_ns = now_ns

    def expired(self, now_ns: int) -> bool:
        """Return whether setpoints have ceased; to be asked at every tick."""
        return self._silence.of(self.obeyed_ns, now_ns) > self.timeout_ns and self.obeyed_ns != 0

    def age_s(self, now_ns: int) -> float:
        """The age of the setpoint, s; 0 before the first."""
        return max(now_ns - self.obeyed_ns, 0) / NS_PER_S if self.obeyed_ns else 0.0


class SimulatedController:
    """Turns setpoints into the motion that the servo follows.

    Setpoints are extrapolated by their velocity and acceleration until the next arrives; a jump is followed within the
    robot's acceleration. Silence, a stop, or a setpoint that is not finite end in a jerk-limited stop, after which only
    a new activation moves the arm.
    """

    def __init__(self, config: ServoConfig, limits: JointLimits, q0: Array) -> None:
        self._config = config
        self._limits = limits
        accelerations = np.full(len(q0), config.stop_acceleration_rad_s2)
        self._stop_limits = replace(limits, acceleration=accelerations)
        self._stop_from: JointMotion | None = None
        self._stop_s = 0.0
        self.setpoints = SetpointWatch(round(config.watchdog_ms * NS_PER_MS))
        self.motion = JointMotion.at_rest(q0)
        self.activation = 0
        self.active = False
        self.fault = ControllerFault.NONE
        self.gripper = GripperCommand.KEEP

    @property
    def resting(self) -> bool:
        """No motion is under way or requested."""
        return not self.active and self._stop_from is None

    def asked(self, command: CellCommand) -> bool:
        """Return whether the driver asks for an activation that can now be given."""
        return self.resting and command.activation != self.activation

    def tick(self, command: CellCommand, measured_q: Array, now_ns: int, dt: float) -> JointMotion:
        """The motion to follow `dt` seconds after the last, at `now_ns`; the command as in `simulation.memory`."""
        if not self.resting and np.abs(self.motion.q - measured_q).max() > self._config.following_error_rad:
            self.active, self._stop_from, self.fault = False, None, ControllerFault.BLOCKED
            self.motion = JointMotion.at_rest(measured_q)
        if self.active:
            self._take(command, now_ns)
        if self.active:
            self.motion = self._towards(self._setpoint(command, now_ns), dt)
        elif self._stop_from is not None:
            self._stop_s += dt
            self.motion = stopping(self._stop_from, self._stop_limits, self._stop_s)
            if self.motion.resting:
                self._stop_from = None
        return self.motion

    def stop(self, fault: ControllerFault | None = None) -> None:
        """Begin the jerk-limited stop, unless one is under way or the arm rests; setpoints are taken no more."""
        self.active = False
        self.fault = self.fault if fault is None else fault
        if self._stop_from is None and not self.motion.resting:
            most = self._stop_limits.acceleration
            self._stop_from = replace(self.motion, ddq=np.clip(self.motion.ddq, -most, most))
            self._stop_s = 0.0

    def activate(self, setup: Record, command: CellCommand) -> None:
        """Take setpoints from rest at the command's posture, or set `fault` if the arm is not there."""
        self.activation, self.gripper = command.activation, GripperCommand.KEEP
        config = self._config
        if not np.abs(command.q - self.motion.q).max() <= config.activation_tolerance_rad:
            self.fault = ControllerFault.APART
            return
        timeout_ns = min(round(config.watchdog_ms * NS_PER_MS), int(setup["timeout_ns"]))
        self.setpoints = SetpointWatch(timeout_ns, command.seq)
        self._stop_limits = replace(
            self._stop_limits,
            acceleration=np.minimum(setup["acceleration"], config.stop_acceleration_rad_s2),
            jerk=np.minimum(setup["jerk"], config.stop_jerk_rad_s3),
        )
        self.active, self.fault = True, ControllerFault.NONE

    def _take(self, command: CellCommand, now_ns: int) -> None:
        expired = self.setpoints.expired(now_ns)
        if command.activation != self.activation or not command.run:
            self.stop()
        elif command.seq != self.setpoints.seq:
            if not JointMotion(command.q, command.dq, command.ddq).finite:
                self.stop(ControllerFault.NOT_FINITE)
                return
            self.setpoints.obey(command.seq, now_ns)
            self.gripper = GRIPPER_COMMANDS[command.gripper]
        elif expired:
            self.stop(ControllerFault.WATCHDOG)

    def _setpoint(self, command: CellCommand, now_ns: int) -> JointMotion:
        """The command's setpoint, extrapolated to now."""
        age = self.setpoints.age_s(now_ns)
        curved = min(age, self._config.extrapolation_ms / 1000.0)
        q, dq, ddq = command.q, command.dq, command.ddq
        velocity = dq + curved * ddq
        position = q + curved * dq + 0.5 * curved * curved * ddq + (age - curved) * velocity
        return JointMotion(position, velocity, ddq if age == curved else np.zeros(len(q)))

    def _towards(self, wanted: JointMotion, dt: float) -> JointMotion:
        """The motion `dt` seconds from now, within the robot's own limits, though the setpoint may jump."""
        now, limits, top = self.motion, self._limits, self._limits.acceleration
        follow = 2.0 * math.pi * self._config.follow_hz
        error = _within(wanted.q, limits.lower, limits.upper) - now.q
        # Critically damped near by; from far, no faster than half the acceleration can brake.
        catch_up = np.copysign(np.minimum(0.5 * follow * np.abs(error), np.sqrt(top * np.abs(error))), error)
        ddq = wanted.ddq + 2.0 * follow * (wanted.dq + catch_up - now.dq)
        dq = _within(now.dq + dt * _within(ddq, -top, top), -limits.velocity, limits.velocity)
        return JointMotion(now.q + 0.5 * dt * (now.dq + dq), dq, (dq - now.dq) / dt)


def controller_limits(config: ServoConfig, names: tuple[str, ...], lower: Array, upper: Array) -> JointLimits:
    """The robot's own limits; ModelError when the servo's configuration is for another number of joints."""
    n = len(names)
    if len(config.max_acceleration_rad_s2) != n:
        raise ModelError(f"simulation.servo.max_acceleration_rad_s2 needs {n} values, one for each joint")
    velocity, jerk = np.full(n, config.max_velocity_rad_s), np.full(n, config.stop_jerk_rad_s3)
    return JointLimits(names, lower, upper, velocity, np.array(config.max_acceleration_rad_s2), jerk)


def _within(values: Array, lower: Array, upper: Array) -> Array:
    return np.minimum(np.maximum(values, lower), upper)  # np.clip costs five times as much for six joints

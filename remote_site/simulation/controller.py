"""The simulated robot controller's mind: which joint motion to follow now, and its own command watchdog. Pure."""

import math
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import ModelError
from common.geometry import Array
from remote_site.drivers.silence import Silence
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import JointStop, joint_stop
from remote_site.shared_record import Record
from remote_site.simulation.config import ServoConfig


class ControllerFault(IntEnum):
    """Why the controller takes no setpoints."""

    NONE = 0
    WATCHDOG = 1
    NOT_FINITE = 2
    APART = 3
    BLOCKED = 4


@dataclass(frozen=True, slots=True)
class ArmLimits:
    """The robot's own limits, each (n,): positions in rad, velocity in rad/s."""

    lower: Array
    upper: Array
    velocity: Array


@dataclass(slots=True)
class _Stop:
    joints: list[JointStop]
    elapsed_s: float = 0.0

    def advance(self, dt: float) -> JointMotion:
        self.elapsed_s += dt
        q, dq, ddq = zip(*(joint.at(self.elapsed_s) for joint in self.joints), strict=True)
        return JointMotion(np.array(q), np.array(dq), np.array(ddq))


class SimulatedController:
    """Turns setpoints into the motion that the servo follows.

    Setpoints are extended by their velocity and acceleration until the next arrives; what jumps is followed within the
    robot's acceleration. Silence, a stop, or a setpoint that is not finite end in a jerk-limited stop, after which only
    a new activation moves the arm.
    """

    def __init__(self, config: ServoConfig, limits: ArmLimits, q0: Array) -> None:
        self._config = config
        self._limits = limits
        self._follow = 2.0 * math.pi * config.follow_hz
        self._timeout_ns = round(config.watchdog_ms * NS_PER_MS)
        self._top = np.array(config.max_acceleration_rad_s2)
        if len(self._top) != len(q0):
            raise ModelError(f"simulation.servo.max_acceleration_rad_s2 needs {len(q0)} values, one for each joint")
        self._stop_acceleration = np.full(len(q0), config.stop_acceleration_rad_s2)
        self._stop_jerk = np.full(len(q0), config.stop_jerk_rad_s3)
        self._stop: _Stop | None = None
        self._arrival_ns = 0
        self._silence = Silence(self._timeout_ns // 2)
        self._seq = -1
        self.motion = JointMotion.at_rest(q0)
        self.activation = 0
        self.active = False
        self.fault = ControllerFault.NONE
        self.gripper_open = True
        self.obeyed_seq = 0
        self.obeyed_ns = 0

    @property
    def resting(self) -> bool:
        """No motion is under way or asked for."""
        return not self.active and self._stop is None

    def asked(self, command: Record) -> bool:
        """Whether the driver asks for an activation that can now be given."""
        return self.resting and int(command["activation"]) != self.activation

    def tick(self, command: Record, measured_q: Array, now_ns: int, dt: float) -> JointMotion:
        """The motion to follow `dt` seconds after the last, at `now_ns`; the command as in `shared_memory`."""
        if not self.resting and np.abs(self.motion.q - measured_q).max() > self._config.following_error_rad:
            self._hold_blocked(measured_q)
        if self.active:
            self._take(command, now_ns)
        if self.active:
            self.motion = self._towards(self._setpoint(command, now_ns), dt)
        elif self._stop is not None:
            self.motion = self._stop.advance(dt)
            if self.motion.resting:
                self._stop = None
        return self.motion

    def stop(self) -> None:
        """Begin the jerk-limited stop, unless one is under way or the arm rests; setpoints are taken no more."""
        self.active = False
        if self._stop is None and not self.motion.resting:
            most = self._stop_acceleration
            ddq = np.clip(self.motion.ddq, -most, most)
            states = zip(self.motion.q.tolist(), self.motion.dq.tolist(), ddq.tolist(), strict=True)
            limits = zip(most.tolist(), self._stop_jerk.tolist(), strict=True)
            self._stop = _Stop([joint_stop(s, *limit) for s, limit in zip(states, limits, strict=True)])

    def activate(self, setup: Record, command: Record) -> None:
        """Take setpoints from rest at the command's posture, or say in `fault` that the arm is not there."""
        self.activation = int(command["activation"])
        apart = np.abs(command["q"] - self.motion.q).max()
        if not apart <= self._config.activation_tolerance_rad:
            self.fault = ControllerFault.APART
            return
        self._timeout_ns = min(round(self._config.watchdog_ms * NS_PER_MS), int(setup["timeout_ns"]))
        self._silence = Silence(self._timeout_ns // 2)
        self._stop_acceleration = np.minimum(setup["acceleration"], self._config.stop_acceleration_rad_s2)
        self._stop_jerk = np.minimum(setup["jerk"], self._config.stop_jerk_rad_s3)
        self.active, self.fault = True, ControllerFault.NONE
        self._seq = int(command["seq"])
        self.obeyed_seq, self.obeyed_ns = 0, 0

    def _take(self, command: Record, now_ns: int) -> None:
        silent_ns = self._silence.of(self._arrival_ns, now_ns)
        if int(command["activation"]) != self.activation or not command["run"]:
            self.stop()
        elif int(command["seq"]) != self._seq:
            self._obey(command, now_ns)
        elif self.obeyed_ns and silent_ns > self._timeout_ns:
            self._fail(ControllerFault.WATCHDOG)

    def _obey(self, command: Record, now_ns: int) -> None:
        if not JointMotion(command["q"], command["dq"], command["ddq"]).finite:
            self._fail(ControllerFault.NOT_FINITE)
            return
        self._seq = self.obeyed_seq = int(command["seq"])
        self._arrival_ns = self.obeyed_ns = now_ns
        self.gripper_open = bool(command["gripper_open"])

    def _hold_blocked(self, measured_q: Array) -> None:
        self.active, self._stop, self.fault = False, None, ControllerFault.BLOCKED
        self.motion = JointMotion.at_rest(measured_q)

    def _fail(self, fault: ControllerFault) -> None:
        self.fault = fault
        self.stop()

    def _setpoint(self, command: Record, now_ns: int) -> JointMotion:
        age = max(now_ns - self._arrival_ns, 0) / NS_PER_S if self.obeyed_ns else 0.0
        curved = min(age, self._config.extrapolation_ms / 1000.0)
        q, dq, ddq = command["q"], command["dq"], command["ddq"]
        velocity = dq + curved * ddq
        position = q + curved * dq + 0.5 * curved * curved * ddq + (age - curved) * velocity
        return JointMotion(position, velocity, ddq if age == curved else np.zeros(len(q)))

    def _towards(self, wanted: JointMotion, dt: float) -> JointMotion:
        now, follow, limits = self.motion, self._follow, self._limits
        target = _within(wanted.q, limits.lower, limits.upper)
        error, top = target - now.q, self._top
        # Critically damped near by; from far, no faster than half the acceleration can brake.
        catch_up = np.copysign(np.minimum(0.5 * follow * np.abs(error), np.sqrt(top * np.abs(error))), error)
        ddq = wanted.ddq + 2.0 * follow * (wanted.dq + catch_up - now.dq)
        dq = _within(now.dq + dt * _within(ddq, -top, top), -limits.velocity, limits.velocity)
        return JointMotion(now.q + 0.5 * dt * (now.dq + dq), dq, (dq - now.dq) / dt)


def _within(values: Array, lower: Array | float, upper: Array | float) -> Array:
    return np.minimum(np.maximum(values, lower), upper)  # np.clip costs five times as much for six joints

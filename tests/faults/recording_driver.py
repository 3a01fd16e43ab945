"""The driver under test: a robot that follows perfectly, a record of all that it receives, faults on command."""

import os
import time
from dataclasses import replace
from typing import Any

import numpy as np

from common.clock import NS_PER_MS
from common.errors import DriverError
from common.geometry import Array
from lab.stage.network.command_socket import CommandSocket
from remote_site.drivers.driver import Capabilities, Driver, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.drivers.registry import DriverHost

WRITE, READ, ACTIVATE, STOP = range(4)
JOINTS = 6
JUMP_RAD, JUMP_NS = 1.0, 8 * NS_PER_MS
RECORD = np.dtype(
    [("kind", "<i4"), ("activation", "<i4"), ("t_ns", "<i8"), ("planned_ns", "<i8"), ("motion", "<f8", (3, JOINTS))]
)


class RecordingDriver:
    """A `Driver` around a kinematic one; the record outlives a killed process.

    Commanded `raises`, it fails in every write; `blocks_ms` delays one. It reports a `fault`, explained by `sentence`,
    with which its robot stops by itself, until the command is an empty one. `misreads` joint 1 as "nan", or "jumped" by
    1 rad for 8 ms, or all joints as they are now: "held" with new stamps, "frozen" with the same. `stands_at` is its
    posture before the first activation.
    """

    def __init__(self, host: DriverHost) -> None:
        self._driver: Driver = KinematicDriver(host.clock)
        self._clock, self._activation = host.clock, 0
        self._commands = CommandSocket(str(host.options["orders"]))
        self._file = os.open(str(host.options["record"]), os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        stands_at = str(host.options.get("stands_at", ""))
        self._found = np.array([float(q) for q in stands_at.split()]) if stands_at else None
        self._raises, self._blocks_ms, self._fault, self._sentence = False, 0.0, "", "as commanded"
        self._misreads = ""
        self._kept: RobotReading | None = None

    @property
    def capabilities(self) -> Capabilities:
        """The kinematic robot's."""
        return self._driver.capabilities

    def configure(self, setup: DriverSetup) -> None:
        """Hand it on."""
        self._driver.configure(setup)

    def activate(self, q0: Array) -> None:
        """Note it and hand it on, unless the robot's fault is still there."""
        if self._fault:
            raise DriverError(f"the robot reports {self._fault}")
        self._driver.activate(q0)
        self._activation, self._found = self._activation + 1, None
        self._note(ACTIVATE, self._clock.now_ns(), q0, np.zeros(JOINTS), np.zeros(JOINTS))

    def read(self) -> RobotReading:
        """Record the reading, and add the commanded fault."""
        self._obey()
        if self._found is not None:
            return RobotReading(self._clock.now_ns(), self._found, np.zeros(JOINTS), None, None, None)
        reading = self._driver.read()
        self._note(READ, reading.t_ns, reading.q, reading.dq, np.zeros(JOINTS))
        reading = self._misread(reading)
        return (
            replace(reading, fault=RobotFault(FaultCode(self._fault), self._sentence, "E42"))
            if self._fault
            else reading
        )

    def write(self, command: JointCommand) -> JointCommand:
        """Record the command, fail as commanded, pass it on."""
        self._note(WRITE, command.t_ns, command.q, command.dq, command.ddq)
        blocks_ms, self._blocks_ms = self._blocks_ms, 0.0
        time.sleep(blocks_ms / 1e3)
        if self._raises:
            raise ZeroDivisionError("as commanded")
        return self._driver.write(command)

    def stop(self) -> None:
        """Note it and hand it on."""
        self._note(STOP, self._clock.now_ns(), *np.zeros((3, JOINTS)))
        self._driver.stop()

    def deactivate(self) -> None:
        """Hand it on."""
        self._driver.deactivate()

    def told(self, fields: dict[str, Any]) -> None:
        """What else a robot is commanded."""

    def _misread(self, reading: RobotReading) -> RobotReading:
        """The reading as commanded; "" keeps it."""
        self._kept = reading if self._kept is None or not self._misreads else self._kept
        if self._misreads == "nan":
            return replace(reading, q=np.array([np.nan, *reading.q[1:]]))
        if self._misreads == "jumped":
            off = JUMP_RAD if reading.t_ns - self._kept.t_ns < JUMP_NS else 0.0
            return replace(reading, q=reading.q + off * np.eye(JOINTS)[0])
        if self._misreads == "held":
            return replace(reading, q=self._kept.q, dq=self._kept.dq)
        return replace(self._kept, fault=reading.fault)

    def _obey(self) -> None:
        fields = self._commands.take()
        self.told(fields)
        self._raises = fields.get("raises", self._raises)
        self._blocks_ms = fields.get("blocks_ms", self._blocks_ms)
        if fields.get("fault"):
            self._driver.stop()
        self._fault, self._sentence = fields.get("fault", self._fault), fields.get("sentence", self._sentence)
        self._misreads = fields.get("misreads", self._misreads)

    def _note(self, kind: int, planned_ns: int, *motion: Array) -> None:
        record = np.zeros((), RECORD)
        record["kind"], record["activation"], record["planned_ns"] = kind, self._activation, planned_ns
        record["t_ns"], record["motion"] = self._clock.now_ns(), motion
        os.write(self._file, record.tobytes())

"""The driver of the simulated cell: setpoints and readings through shared memory."""

import numpy as np

from common.clock import NS_PER_MS, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, JointCommand, RobotReading
from remote_site.drivers.faults import APART, NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.safety.silence import Silence
from remote_site.shared_record import Record
from remote_site.simulation.controller import ControllerFault
from remote_site.simulation.memory import GRIPPER_COMMANDS, CellMemory

SILENT_NS = 100 * NS_PER_MS
PAUSE_NS = 50 * NS_PER_MS

WATCHDOG_MS = 100.0
FAULTS = {
    ControllerFault.WATCHDOG: (FaultCode.WATCHDOG, "setpoints ceased, the arm has stopped"),
    ControllerFault.NOT_FINITE: (
        FaultCode.NOT_FINITE,
        "a setpoint is not finite, the arm has stopped",
    ),
    ControllerFault.BLOCKED: (
        FaultCode.BLOCKED,
        "the arm is blocked and holds its position; clear its path",
    ),
    ControllerFault.APART: (FaultCode.APART, APART.sentence),
}
NO_READINGS = RobotFault(FaultCode.SILENT, "the simulated cell gives no readings; is its process running?")


class SimulatedDriver:
    """A `Driver` whose robot is the simulated cell of another process."""

    def __init__(self, memory: CellMemory, clock: Clock) -> None:
        self._memory = memory
        self._clock = clock
        self._silence = Silence(PAUSE_NS)
        self._command = np.zeros((), dtype=memory.command.dtype)
        self._joints = len(self._command["q"])
        self._configured = False

    @property
    def capabilities(self) -> Capabilities:
        """An arm of the cell's joints with a gripper, and a controller with a watchdog."""
        return Capabilities(
            rate_hz=1000.0, joints=self._joints, gripper=True, force=True, watchdog_ms=WATCHDOG_MS, queued_periods=0
        )

    def configure(self, setup: DriverSetup) -> None:
        """Hand the command time-out, the limits of the stop and of the grip to the robot's controller."""
        if len(setup.joint_names) != self._joints:
            raise DriverError(f"the simulated arm has {self._joints} joints, the model {len(setup.joint_names)}")
        record = np.zeros((), dtype=self._memory.setup.dtype)
        record["timeout_ns"] = setup.command_timeout_ns
        record["acceleration"], record["jerk"] = setup.limits.acceleration, setup.limits.jerk
        record["grip_force_n"] = setup.grip_force_n
        self._memory.setup.write(record)
        self._configured = True

    def activate(self, q0: Array) -> None:
        """Ask the controller to take setpoints from rest at `q0`; a later reading shows when it does."""
        reading = self._memory.reading.read()
        if not self._configured:
            raise DriverError("configure the simulated driver before it is activated")
        if self._silent(reading):
            raise DriverError(NO_READINGS.sentence)
        if not reading["resting"]:
            raise DriverError("the simulated arm still moves; activate it when it rests")
        command = self._command
        command["activation"] = int(reading["activation"]) + 1
        command["run"], command["gripper"] = True, GRIPPER_COMMANDS.index(GripperCommand.KEEP)
        command["q"], command["dq"], command["ddq"] = q0, 0.0, 0.0
        self._memory.command.write(command)

    def read(self) -> RobotReading:
        """The newest reading of the cell; DriverError before its first."""
        reading = self._memory.reading.read()
        if not reading["t_ns"]:
            raise DriverError(NO_READINGS.sentence)
        return RobotReading(
            t_ns=int(reading["t_ns"]),
            q=reading["q"],
            dq=reading["dq"],
            gripper=GripperReading(float(reading["opening_m"]), float(reading["force_n"])),
            fault=self._fault(reading),
            obeyed_seq=int(reading["obeyed_seq"]) if reading["obeyed_ns"] else None,
        )

    def write(self, command: JointCommand) -> JointCommand:
        """Write a setpoint for the controller; DriverError before activation and after any stop."""
        record, reading = self._command, self._memory.reading.read()
        if not record["run"]:
            raise DriverError("the simulated arm is stopped; activate it before it is commanded")
        if reading["activation"] == record["activation"] and not reading["active"]:
            raise DriverError(str(self._fault(reading)))
        record["seq"], record["t_ns"] = command.seq, command.t_ns
        record["gripper"] = GRIPPER_COMMANDS.index(command.gripper)
        record["q"], record["dq"], record["ddq"] = command.q, command.dq, command.ddq
        self._memory.command.write(record)
        return command

    def stop(self) -> None:
        """Have the controller stop the arm within its limits and hold it."""
        self._command["run"] = False
        self._memory.command.write(self._command)

    def deactivate(self) -> None:
        """Stop, and take no more setpoints."""
        self.stop()

    def _fault(self, reading: Record) -> RobotFault | None:
        if self._silent(reading):
            return NO_READINGS
        if int(reading["activation"]) != int(self._command["activation"]):
            return NOT_ACTIVATED
        if reading["active"]:
            return None
        fault = ControllerFault(int(reading["fault"]))
        return RobotFault(*FAULTS[fault], native=fault.name) if fault in FAULTS else STOPPED

    def _silent(self, reading: Record) -> bool:
        return self._silence.of(int(reading["t_ns"]), self._clock.now_ns()) > SILENT_NS

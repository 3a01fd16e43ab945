"""Control's end of the shared memory: orders to the driver's process, its reports, and whether it still answers."""

import math
from dataclasses import dataclass, replace

import numpy as np

from common.clock import NS_PER_MS, Clock
from common.geometry import Array
from common.messages import GripperState, GripperStatus
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import NOT_ACTIVATED, FaultCode, RobotFault
from remote_site.drivers.keeper import DEADLINE_NS, Order, late_call
from remote_site.drivers.memory import DriverMemory
from remote_site.kinematics.joints import JointMotion
from remote_site.shared_memory import Record

SILENT_NS = 100 * NS_PER_MS
STARTING = RobotFault(FaultCode.NOT_ACTIVATED, "the driver has measured nothing yet")


@dataclass(frozen=True, slots=True)
class RobotReport:
    """The robot as its driver's process tells it; `fault` is None while it takes commands.

    `t_ns` is when `q`, `dq` (rad, rad/s) were measured, 0 before anything was. `sent` is the motion that was sent last.
    `obeyed_seq` is the newest command that has reached the robot's motion. `answered`: the last activation was decided.
    """

    t_ns: int
    q: Array
    dq: Array
    gripper: GripperState | None
    fault: RobotFault | None
    obeyed_seq: int | None
    sent: JointMotion
    answered: bool

    @property
    def ready(self) -> bool:
        """The robot takes commands."""
        return self.fault is None


class DriverLink:
    """What control has of the driver; no call waits for it."""

    def __init__(self, memory: DriverMemory, clock: Clock) -> None:
        self._memory = memory
        self._clock = clock
        self._activation = self._diversions = 0
        self._last: JointCommand | None = None
        self._report = self._decoded(memory.report.read())

    def read(self) -> RobotReport:
        """The newest report; not ready when the driver's process or one of its calls takes too long."""
        record = self._memory.report.read()
        report = self._decoded(record)
        now_ns = self._clock.now_ns()
        busy_ns = self._memory.busy.since_ns
        if busy_ns and now_ns - busy_ns > DEADLINE_NS:
            report = replace(report, fault=late_call("call", now_ns - busy_ns))
        elif record["at_ns"] and now_ns - int(record["at_ns"]) > SILENT_NS:
            late_ms = (now_ns - int(record["at_ns"])) / NS_PER_MS
            report = replace(report, fault=RobotFault(FaultCode.PROCESS, f"the driver is silent for {late_ms:.0f} ms"))
        self._report = report
        return report

    def write(self, command: JointCommand) -> JointCommand:
        """Order a command; what was really sent instead when the driver's process had left the course."""
        record = self._memory.report.read()
        diversions = int(record["diversions"])
        if diversions != self._diversions:
            self._diversions = diversions
            q, dq, ddq = record["sent"]
            return replace(command, q=q, dq=dq, ddq=ddq)
        self._order(command, run=True)
        return command

    def activate(self, q0: Array) -> None:
        """Have the robot take commands from rest at `q0`; reports say what became of it."""
        self._activation += 1
        zero = np.zeros(len(q0))
        is_open = self._report.gripper is None or self._report.gripper.commanded_open
        seq = self._last.seq if self._last is not None else 0
        self._order(JointCommand(seq, self._clock.now_ns(), np.asarray(q0), zero, zero, is_open), run=True)

    def stop(self) -> None:
        """Have the robot stopped; only an activation moves it again."""
        if self._last is not None:
            self._order(self._last, run=False)

    def _order(self, command: JointCommand, *, run: bool) -> None:
        self._last = command
        self._memory.orders.write(Order(self._activation, run, self._diversions, command))
        self._memory.bell.ring()

    def _decoded(self, record: Record) -> RobotReport:
        answered = int(record["answered"]) == self._activation
        q, dq = record["joints"]
        return RobotReport(
            t_ns=int(record["t_ns"]),
            q=q,
            dq=dq,
            gripper=_gripper(record),
            fault=_fault(record) if answered else NOT_ACTIVATED,
            obeyed_seq=int(record["obeyed_seq"]) if record["has_obeyed"] else None,
            sent=JointMotion(*record["sent"]),
            answered=answered,
        )


def _fault(record: Record) -> RobotFault | None:
    if not record["at_ns"]:
        return STARTING
    code = record["code"].item()
    if not code:
        return None
    native, sentence = (record[key].item().decode(errors="replace") for key in ("native", "sentence"))
    return RobotFault(FaultCode(code.decode()), sentence, native)


def _gripper(record: Record) -> GripperState | None:
    grip = record["grip"].item()
    if not grip:
        return None
    force = float(record["force_n"])
    return GripperState(
        float(record["opening_m"]),
        None if math.isnan(force) else force,
        bool(record["gripper_open"]),
        GripperStatus(grip.decode()),
    )

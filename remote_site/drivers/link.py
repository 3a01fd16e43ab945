"""Control's end of the shared memory: orders to the driver's process, its reports, and whether it still answers."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.geometry import Array
from common.messages.robot import GripperCommand, GripperState, GripperStatus
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.faults import NOT_ACTIVATED, FaultCode, RobotFault
from remote_site.drivers.memory import DriverMemory, DriverReport
from remote_site.drivers.supervisor.orders import DriverOrder
from remote_site.drivers.supervisor.reading_check import stale
from remote_site.drivers.supervisor.watched_driver import DEADLINE_NS, late_call
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.safety.silence import Silence
from remote_site.safety.stopping import stopping

SILENT_NS = 100 * NS_PER_MS
PAUSE_NS = 50 * NS_PER_MS  # a longer pause of control itself is not the driver's silence
STARTING = RobotFault(FaultCode.NOT_ACTIVATED, "the driver has measured nothing yet")


class RobotReport(NamedTuple):
    """The robot as its driver's process reports it; `fault` is None while it takes commands.

    `t_ns` is when `q`, `dq` (rad, rad/s) were measured, 0 before anything was; `age_ns` is how old they are, without
    pauses of this process, and `oldest_ns` how old they may become.

    `sent` is the motion to plan from: while the robot takes commands, the last command; from the request of an
    activation until it is answered, rest where it was requested; otherwise the motion commanded last, or where its stop
    has come by now.

    `obeyed_seq` is the newest command that has reached the robot's motion. `answered`: the last activation was handled.
    `diverted`: a stop of the driver's own has begun since the last command. `written` is what the robot was given last,
    after every limit, None before the first: its `seq` is that of the command that it comes from.
    """

    t_ns: int
    q: Array
    dq: Array
    gripper: GripperState | None
    fault: RobotFault | None
    obeyed_seq: int | None
    sent: JointMotion
    answered: bool
    age_ns: int = 0
    oldest_ns: int = 0
    diverted: bool = False
    written: JointCommand | None = None

    @property
    def ready(self) -> bool:
        """Return whether the robot takes commands."""
        return self.fault is None

    @property
    def measured(self) -> bool:
        """Return whether the robot is where `q` is: it has been measured, and not too long ago."""
        return self.t_ns > 0 and self.age_ns <= self.oldest_ns


class DriverLink:
    """Control's access to the driver; no call waits for it."""

    def __init__(self, memory: DriverMemory, limits: JointLimits, clock: Clock) -> None:
        self._memory = memory
        self._limits = limits
        self._clock = clock
        self._silence, self._unmeasured = Silence(PAUSE_NS), Silence(PAUSE_NS)
        self._activation = self._stop_count = 0
        self._last: JointCommand | None = None
        self._raw = memory.report.read()
        self._report = self._decoded(self._raw)

    def read(self) -> RobotReport:
        """Read the newest report; not ready when the driver's process, a call of it or a new reading takes too long."""
        raw = self._raw = self._memory.report.read()
        now_ns = self._clock.now_ns()
        age_ns, diverted = self._unmeasured.of(raw.t_ns, now_ns), raw.stop_count != self._stop_count
        report = self._decoded(raw)._replace(age_ns=age_ns, diverted=diverted)
        busy_ns, silent_ns = self._memory.busy.since_ns, self._silence.of(raw.at_ns, now_ns)
        if busy_ns and now_ns - busy_ns > DEADLINE_NS:
            report = report._replace(fault=late_call("call", now_ns - busy_ns))
        elif raw.at_ns and silent_ns > SILENT_NS:
            late = f"the driver's process has been silent for {silent_ns / NS_PER_MS:.0f} ms"
            report = report._replace(fault=RobotFault(FaultCode.PROCESS, late))
        elif report.ready and not report.measured:
            report = report._replace(fault=stale(report.age_ns, report.oldest_ns))
        if report.ready and self._last is not None:
            report = report._replace(sent=self._last.motion)
        self._report = report
        return report

    def write(self, command: JointCommand) -> JointCommand:
        """Order a command; if the last report shows that a stop began, order the stop's motion at that time instead.

        So control continues from within the stop: it plans its next command from what is returned.
        """
        raw = self._raw
        if raw.stop_count != self._stop_count:
            self._stop_count = raw.stop_count
            sent = self._sent(raw, command.t_ns)
            command = replace(command, q=sent.q, dq=sent.dq, ddq=sent.ddq)
        self._order(command, run=True)
        return command

    def activate(self, q0: Array) -> None:
        """Ask the robot to take commands from rest at `q0`, its gripper as it is; a later report has the answer."""
        self._activation += 1
        zero = np.zeros(len(q0))
        seq = self._last.seq if self._last is not None else 0
        q = np.asarray(q0)
        self._order(JointCommand(seq, self._clock.now_ns(), q, zero, zero, GripperCommand.KEEP), run=True)

    def stop(self) -> None:
        """Stop the robot; only an activation moves it again."""
        if self._last is not None:
            self._order(replace(self._last, gripper=GripperCommand.KEEP), run=False)

    def _order(self, command: JointCommand, *, run: bool) -> None:
        self._last = command
        self._memory.orders.write(DriverOrder(self._activation, run, self._stop_count, command))
        self._memory.bell.ring()

    def _decoded(self, raw: DriverReport) -> RobotReport:
        answered = raw.activation == self._activation
        q, dq = raw.motions[:2]
        return RobotReport(
            t_ns=raw.t_ns,
            q=q,
            dq=dq,
            gripper=_gripper(raw),
            fault=_fault(raw) if answered else NOT_ACTIVATED,
            obeyed_seq=raw.obeyed_seq if raw.has_obeyed else None,
            sent=self._sent(raw, self._clock.now_ns()) if answered or self._last is None else self._last.motion,
            answered=answered,
            oldest_ns=raw.oldest_ns + PAUSE_NS,  # the driver's process judges first
            written=_written(raw),
        )

    def _sent(self, raw: DriverReport, t_ns: int) -> JointMotion:
        """Return the motion commanded last, or that of its stop at a time."""
        motion = JointMotion(*raw.motions[2:5])
        return stopping(motion, self._limits, max(t_ns - raw.onset_ns, 0) / NS_PER_S) if raw.onset_ns else motion


def _written(raw: DriverReport) -> JointCommand | None:
    if not raw.written_ns:
        return None
    q, dq, ddq = raw.motions[5:]
    return JointCommand(raw.written_seq, raw.written_ns, q, dq, ddq, GripperCommand.KEEP)


def _fault(raw: DriverReport) -> RobotFault | None:
    if not raw.at_ns:
        return STARTING
    if not raw.code:
        return None
    return RobotFault(FaultCode(raw.code.decode()), raw.sentence, raw.native)


def _gripper(raw: DriverReport) -> GripperState | None:
    if not raw.grip:
        return None
    force = None if math.isnan(raw.force_n) else raw.force_n
    return GripperState(raw.opening_m, force, GripperCommand(raw.gripper.decode()), GripperStatus(raw.grip.decode()))

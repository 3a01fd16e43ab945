"""Stands between commands and driver: checks each once more, and stops the robot when they cease or break a limit."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import Protocol

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperState
from remote_site.drivers.driver import Driver, DriverSetup, JointCommand, RobotReading
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.drivers.silence import Silence
from remote_site.drivers.supervisor.grip import GripWatch
from remote_site.drivers.supervisor.write_scheduler import WriteScheduler
from remote_site.kinematics.joints import JointMotion
from remote_site.reasons import Code, reason
from remote_site.safety.guard import JointGuard, Refused
from remote_site.safety.stopping import stopping

DEADLINE_NS = 50 * NS_PER_MS
GRACE_TICKS = 3  # a later command finds the stop begun, and goes on from there
SENT_AHEAD = 0.25  # of a tick: so much further the stop may have been sent than the command that ends it
RESTING_RAD_S = 0.02
APART_RAD = 0.05


@dataclass(frozen=True, slots=True)
class DriverOrder:
    """What control wants: to be activated anew when `activation` rises, a command while `run`, otherwise the stop.

    `diversions` is how many control knows of; a command planned before the last one does not count.
    """

    activation: int
    run: bool
    diversions: int
    command: JointCommand


class Phase(Enum):
    """How far the robot is from taking commands."""

    IDLE = auto()
    ACTIVATING = auto()
    ACTIVE = auto()
    STOPPING = auto()


class CallMark(Protocol):
    """Shows other processes since when a call of the driver is under way, in ns; 0 between calls."""

    def set(self, since_ns: int) -> None: ...


class DriverSupervisor:
    """Keeps the last limits and the command time-out of any driver; time comes from its clock.

    Every command is judged against the one before it. When the next is late by three ticks, the verified stop of the
    last one begins as of its time, and `onset_ns` tells control so. The command that is where the stop is at the
    command's own time is taken, and those that go on from there; none older. A broken limit, silence beyond the
    time-out, a failing driver and a robot's fault stay until the next activation. After a driver's call that was late,
    what has come meanwhile is written no faster than the robot's limits allow.
    """

    def __init__(self, driver: Driver, setup: DriverSetup, clock: Clock, mark: CallMark, grip: GripWatch) -> None:
        self._driver, self._setup, self._clock, self._mark, self._grip = driver, setup, clock, mark, grip
        self._guard = JointGuard(setup.limits, setup.dt)
        self._silence = Silence(setup.command_timeout_ns // 2)
        self._grace_ns = round(GRACE_TICKS * setup.dt * NS_PER_S)
        rate = driver.capabilities.rate_hz
        self._period_ns = 0 if rate * setup.dt > 0.99 else round(NS_PER_S / rate)
        self._settle_ns = self._period_ns * (driver.capabilities.queued_periods + 2)
        self._due_ns = 0
        self._tick_ns = round(setup.dt * NS_PER_S)
        self._pace: WriteScheduler[JointCommand] = WriteScheduler()
        self._plan_ns = 0
        self._again = False
        self._led = False
        self._written = 0
        self._under_way: dict[int, int] = {}
        self._onset: tuple[int, JointMotion] | None = None
        self._rested_ns: int | None = None
        self._heard_ns: int | None = None
        self._ordered_ns = 0
        self._command = JointCommand(0, 0, *(np.zeros(len(setup.joint_names)),) * 3, gripper_open=True)
        self.motion = self._sent = JointMotion.at_rest(self._command.q)
        self._sent_seq = 0
        self.phase = Phase.IDLE
        self.asked = self.diversions = 0
        self.fault: RobotFault | None = NOT_ACTIVATED
        self.obeyed_seq: int | None = None
        self.reading: RobotReading | None = None
        self.gripper: GripperState | None = None

    def take(self, orders: Sequence[DriverOrder], now_ns: int) -> None:
        """Obey what control has written since the last call, in order, and stop if nothing was heard for too long."""
        self._watch(now_ns)
        for order in orders:
            if order.activation != self.asked:
                self._activate(order, now_ns)
            elif self.phase is Phase.ACTIVE and not order.run:
                self.stop(STOPPED)
            elif self.phase is Phase.ACTIVE:
                self._ordered_ns = now_ns
                if order.diversions == self.diversions:
                    self._obey(order.command, now_ns)

    def step(self, now_ns: int) -> None:
        """Send what is due, and read the robot."""
        if self._onset is not None:
            self.motion = self._stop_at(self._onset, now_ns)
        failed = self._send(now_ns)
        self._read(now_ns)
        if failed is not None:
            self._fail(failed)  # unless the reading has already told the robot's own reason
        if self.phase is Phase.STOPPING and self.motion.resting and (self._period_ns or self._sent.resting):
            self._rest(now_ns)

    def stop(self, why: RobotFault) -> None:
        """Begin the verified stop as of the last command, and take no more until activated."""
        if self.phase is not Phase.ACTIVE:
            return
        self._onset = self._onset or (self._heard_ns or self._clock.now_ns(), self.motion)
        self.phase, self.fault, self._rested_ns = Phase.STOPPING, why, None

    @property
    def course(self) -> tuple[int, JointMotion]:
        """The onset of the stop under way in ns, and the motion there; 0 and the last motion without one."""
        return self._onset or (0, self.motion)

    @property
    def due_ns(self) -> int | None:
        """When a motion that waits may be written, None if none waits."""
        return self._pace.due_ns if self.phase in (Phase.ACTIVE, Phase.STOPPING) and not self._period_ns else None

    @property
    def settled(self) -> bool:
        """Nothing moves, and nothing will without an activation."""
        return self.phase is Phase.IDLE and (self.reading is None or not _moves(self.reading))

    def _watch(self, now_ns: int) -> None:
        silent_ns = self._silence.of(max(self._heard_ns or 0, self._ordered_ns), now_ns)
        if self.phase is not Phase.ACTIVE or self._heard_ns is None:
            return
        late_ns = now_ns - self._heard_ns
        limit_ns = self._setup.command_timeout_ns
        if silent_ns > limit_ns:
            late = reason(Code.COMMAND_TIMEOUT, age_ms=silent_ns / NS_PER_MS, limit_ms=limit_ns / NS_PER_MS)
            self.stop(RobotFault(FaultCode.COMMAND_TIMEOUT, f"{late.sentence}; activate anew"))
        elif late_ns > self._grace_ns and self.motion.resting:
            self._again = True  # a robot at rest is told so again: only the end of this process starts its watchdog
        elif late_ns > self._grace_ns and self._onset is None:
            self._onset = (self._heard_ns, self.motion)
            self.diversions += 1

    def _obey(self, command: JointCommand, now_ns: int) -> None:
        if self._onset is not None:
            self._hand_over(self._onset, command, now_ns)
            return
        verdict = self._guard.check(command.motion, self.motion)
        if isinstance(verdict, Refused):
            self.stop(RobotFault(FaultCode.LIMITS, f"{verdict.reason.sentence}; the arm stops; activate anew"))
            return
        self._follow(command, self._plan_ns + self._tick_ns, now_ns)

    def _hand_over(self, onset: tuple[int, JointMotion], command: JointCommand, now_ns: int) -> None:
        """Let control go on from within the stop, if its command is where the stop is at the command's own time."""
        plan_ns = self._plan_ns + command.t_ns - onset[0]
        meets = self._guard.same(command.motion, self._stop_at(onset, command.t_ns))
        ahead_ns = max(self._pace.planned_ns - plan_ns, 0)
        if not meets or ahead_ns > SENT_AHEAD * self._tick_ns:
            self.diversions += 1  # the stop went on while this was under way
            return
        self._onset = None
        self._pace.owe(2 * ahead_ns)  # the stop braked meanwhile, as hard as the plan may have sped up
        # a robot that was not sent all of the stop goes there, too
        for between_ns in range(max(self._plan_ns, self._pace.planned_ns) + self._tick_ns, plan_ns, self._tick_ns):
            self._pace.add(between_ns, self._stopping_at(onset, between_ns))
        self._follow(command, plan_ns, now_ns)  # what was sent is never taken back

    def _follow(self, command: JointCommand, plan_ns: int, now_ns: int) -> None:
        self.motion, self._command = command.motion, command
        self._heard_ns, self._plan_ns = now_ns, plan_ns
        self._pace.add(plan_ns, command)

    def _stopping_at(self, onset: tuple[int, JointMotion], plan_ns: int) -> JointCommand:
        motion = self._stop_at(onset, onset[0] + plan_ns - self._plan_ns)
        return replace(self._command, q=motion.q, dq=motion.dq, ddq=motion.ddq)

    def _stop_at(self, onset: tuple[int, JointMotion], t_ns: int) -> JointMotion:
        onset_ns, motion = onset
        return stopping(motion, self._setup.limits, max(t_ns - onset_ns, 0) / NS_PER_S)

    def _activate(self, order: DriverOrder, now_ns: int) -> None:
        self.asked = order.activation
        if self.phase in (Phase.ACTIVE, Phase.STOPPING) or (self.reading and _moves(self.reading)):
            self.stop(STOPPED)
            self.fault = RobotFault(FaultCode.REFUSED, "the arm still moves; activate it when it rests")
            return
        self.phase, self.fault = Phase.ACTIVATING, NOT_ACTIVATED
        self._command, self.motion = order.command, JointMotion.at_rest(order.command.q)
        self._heard_ns, self._onset, self._due_ns, self._sent = None, None, now_ns, self.motion
        self._plan_ns = now_ns
        self._pace.restart(now_ns, now_ns)
        self._led, self.obeyed_seq = True, None
        self._under_way.clear()
        refused = self._call("activate", lambda: self._driver.activate(order.command.q))
        if refused is not None:
            # an earlier activation may have gone half way: the robot must not wait for commands that will not come
            self._call("stop", self._driver.stop)
            self.phase, self.fault, self._led = Phase.IDLE, refused, False

    def _read(self, now_ns: int) -> None:
        readings: list[RobotReading] = []
        failed = self._call("read", lambda: readings.append(self._driver.read()))
        if failed is not None:
            if self.reading is None and self.phase is Phase.IDLE and failed.code is FaultCode.REFUSED:
                return  # nothing has been measured yet
            self._fail(failed)
            return
        reading = self.reading = readings[-1]
        if self.phase is Phase.ACTIVATING:
            self._answer(reading)
        elif reading.fault is not None and self.phase is not Phase.IDLE:
            self._fail(reading.fault)
        if not self._led:
            self.motion = JointMotion.at_rest(reading.q)
        self._note_obeyed(reading.obeyed_seq)
        if reading.gripper is not None:
            measured, wanted = reading.gripper, self._command.gripper_open
            status = self._grip.judge(now_ns, measured.opening_m, wanted_open=wanted)
            self.gripper = GripperState(measured.opening_m, measured.force_n, wanted, status)

    def _answer(self, reading: RobotReading) -> None:
        """End the activation when the robot has answered it."""
        if reading.fault is None and np.abs(reading.q - self.motion.q).max() > APART_RAD:
            self._fail(RobotFault(FaultCode.APART, "the arm is not where it was activated; read it and activate there"))
        elif reading.fault is None:
            self.phase, self.fault = Phase.ACTIVE, None
        elif not reading.fault.calm:
            self.phase, self.fault = Phase.IDLE, reading.fault

    def _send(self, now_ns: int) -> RobotFault | None:
        if self.phase not in (Phase.ACTIVE, Phase.STOPPING) or now_ns < self._due_ns:
            return None
        self._due_ns = max(self._due_ns + self._period_ns, now_ns) if self._period_ns else 0
        again, self._again = self._again or self._period_ns > 0, False
        if not self._advance(now_ns):
            if not again:
                return None
            self._pace.repeat(now_ns)
        motion = self._sent
        self._written += 1
        self._under_way[self._written] = self._sent_seq
        command = JointCommand(self._written, now_ns, motion.q, motion.dq, motion.ddq, self._command.gripper_open)
        return self._call("write", lambda: self._driver.write(command))

    def _advance(self, now_ns: int) -> bool:
        """Go on to what may be written now of what waits or of the stop under way; False if there is nothing."""
        if self._onset is not None and not self._pace.waits(now_ns):
            onset_ns, motion = self._onset
            reached_ns = self._pace.reach(self._plan_ns + now_ns - onset_ns, now_ns)
            self._sent = stopping(motion, self._setup.limits, max(reached_ns - self._plan_ns, 0) / NS_PER_S)
            self._sent_seq = self._command.seq
            return True
        command = self._pace.take(now_ns)
        if command is not None:
            self._sent, self._sent_seq = command.motion, command.seq
        return command is not None

    def _rest(self, now_ns: int) -> None:
        """Hold once the robot has had the time to come to rest too."""
        self._rested_ns = now_ns if self._rested_ns is None else self._rested_ns
        if now_ns - self._rested_ns >= self._settle_ns:
            self.phase, self._onset = Phase.IDLE, None
            failed = self._call("stop", self._driver.stop)
            self.fault = failed or self.fault

    def _fail(self, fault: RobotFault) -> None:
        """The robot cannot be led to rest: it has to stop by itself."""
        if fault.code is FaultCode.REFUSED:
            fault = RobotFault(FaultCode.DRIVER, fault.sentence)
        if self.phase is Phase.IDLE:
            if self.fault is None or self.fault.calm:
                self.fault = fault if not fault.calm else self.fault
            return
        self.phase, self._onset = Phase.IDLE, None
        self.fault = fault if self.fault is None or self.fault.calm else self.fault
        failed = self._call("stop", self._driver.stop)
        if failed is not None:
            self.fault = RobotFault(self.fault.code, f"{self.fault.sentence}; nor does it stop: {failed.sentence}")
        self._led = False

    def _note_obeyed(self, written: int | None) -> None:
        """Which of control's commands has reached the robot's motion."""
        if written in self._under_way:
            self.obeyed_seq = self._under_way[written]
            self._under_way = {own: seq for own, seq in self._under_way.items() if own >= written}

    def _call(self, what: str, call: Callable[[], object]) -> RobotFault | None:
        """Make a call of the driver, watched from outside; the fault when it fails or takes too long."""
        begin_ns = self._clock.now_ns()
        self._mark.set(begin_ns)
        try:
            call()
        except DriverError as error:
            return RobotFault(FaultCode.REFUSED, str(error))
        except Exception as error:  # a stranger's code: whatever it raises is a fault, and told
            return RobotFault(FaultCode.DRIVER, f"the driver's {what} raised {type(error).__name__}: {error}")
        finally:
            self._mark.set(0)
        took_ns = self._clock.now_ns() - begin_ns
        return late_call(what, took_ns) if took_ns > DEADLINE_NS else None


def late_call(what: str, took_ns: int) -> RobotFault:
    """The fault of a call that takes longer than a driver may."""
    limit = f"limit {DEADLINE_NS / NS_PER_MS:.0f} ms"
    return RobotFault(FaultCode.DEADLINE, f"the driver's {what} took {took_ns / NS_PER_MS:.0f} ms ({limit})")


def _moves(reading: RobotReading) -> bool:
    rate: Array = np.abs(reading.dq)
    return bool(rate.max() > RESTING_RAD_S)

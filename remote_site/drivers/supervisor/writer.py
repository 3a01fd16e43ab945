"""Writes commands and the stop to the driver, each when it is due, and tracks which of them the robot obeys."""

import math
from dataclasses import replace

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.driver import Capabilities, DriverSetup, JointCommand
from remote_site.drivers.faults import RobotFault
from remote_site.drivers.gripper_orders import GripperOrders
from remote_site.drivers.position_steps import PositionSteps
from remote_site.drivers.supervisor.stop_plan import StopPlan
from remote_site.drivers.supervisor.watched_driver import WatchedDriver
from remote_site.drivers.supervisor.write_scheduler import LEAST_FRACTION, WriteScheduler
from remote_site.kinematics.joints import JointMotion

ONCE_A_TICK = 0.99  # a robot that takes this many commands a tick gets each of them immediately


class ObeyedCommands:
    """Numbers what is written and knows which of control's commands has reached the robot's motion."""

    def __init__(self) -> None:
        self.seq: int | None = None
        self._number = 0
        self._unconfirmed: dict[int, int] = {}

    def restart(self) -> None:
        """Forget what was written; numbers continue to rise."""
        self._unconfirmed.clear()
        self.seq = None

    def number(self, seq: int) -> int:
        """The number to write the motion of control's command `seq` under."""
        self._number += 1
        self._unconfirmed[self._number] = seq
        return self._number

    def confirm(self, number: int | None) -> None:
        """The robot obeys what was written under this number."""
        if number in self._unconfirmed:
            self.seq = self._unconfirmed[number]
            self._unconfirmed = {own: seq for own, seq in self._unconfirmed.items() if own >= number}


class Settling:
    """The wait until a robot that has been led to rest has had the time to follow, `lag_ns`."""

    def __init__(self, lag_ns: int) -> None:
        self._lag_ns = lag_ns
        self._since_ns: int | None = None

    def restart(self) -> None:
        """It is not at rest."""
        self._since_ns = None

    def over(self, now_ns: int) -> bool:
        """It was led to rest when this was first asked."""
        self._since_ns = now_ns if self._since_ns is None else self._since_ns
        return now_ns - self._since_ns >= self._lag_ns


class LastWritten:
    """The motion that was written last, `command`: on its way to what is due, no further on than `most` (n,) in rad."""

    def __init__(self, command: JointCommand, most: Array) -> None:
        self.command = self._due = command
        self._steps = PositionSteps(most, command.q)

    def restart(self, motion: JointMotion) -> None:
        """The robot rests there."""
        self.command = self._due = _with(self.command, motion)
        self._steps.restart(motion.q)

    def write(self, due: JointCommand | None, now_ns: int) -> JointCommand:
        """Return what is to be written now of the motion that is due, None for the one before."""
        self._due = due or self._due
        self.command = replace(self._due, t_ns=now_ns, q=self._steps.towards(self._due.q))
        return self.command


class PacedWriter:
    """Writes to the robot no faster than planned, and to a slow robot no more often than it takes commands.

    The plan advances by a tick with each command. A slow robot gets the newest motion once a period, or one between two
    where the newest would come too early, again if it is the same; a fast one gets each motion once, as soon as the
    scheduler allows. One that holds gets no position further than a period's motion at full speed from the one before
    it. What the gripper is ordered is begun in no stop, and not where it is too old. To be read: `command` (the newest
    of control's), `written` (the motion that was written last, and when).
    """

    def __init__(self, driver: WatchedDriver, capabilities: Capabilities, setup: DriverSetup) -> None:
        rate = capabilities.rate_hz
        self.period_ns = 0 if rate * setup.dt > ONCE_A_TICK else round(NS_PER_S / rate)
        self._settling = Settling(self.period_ns * (capabilities.queued_periods + 2))
        self._tick_ns = round(setup.dt * NS_PER_S)
        pace_ns = self.period_ns or self._tick_ns
        longest_ns = math.ceil(pace_ns / LEAST_FRACTION) if capabilities.holds else None
        self._driver, self._scheduler = driver, WriteScheduler[JointCommand](longest_ns)
        self._due_ns = self.plan_ns = 0
        self._again = False
        self._gripper = GripperOrders()
        self.obeyed = ObeyedCommands()
        nowhere = np.zeros(len(setup.joint_names))
        self.command = JointCommand(0, 0, nowhere, nowhere, nowhere, GripperCommand.KEEP)
        most = setup.limits.velocity if capabilities.holds else np.full(len(nowhere), math.inf)
        self._last = LastWritten(self.command, most * (pace_ns / NS_PER_S))

    @property
    def written(self) -> JointCommand:
        """The motion that was written last, and when."""
        return self._last.command

    @property
    def written_ns(self) -> int:
        """The plan time of the motion that was written last."""
        return self._scheduler.planned_ns

    @property
    def due_ns(self) -> int | None:
        """The time at which a motion that waits may be written, ns; None if none waits."""
        return None if self.period_ns else self._scheduler.due_ns

    def restart(self, command: JointCommand, now_ns: int) -> None:
        """Begin the plan now, with the robot at rest where the command is."""
        self.command = command
        self._last.restart(JointMotion.at_rest(command.q))
        self._due_ns = self.plan_ns = now_ns
        self._settling.restart()
        self._gripper.withdraw()
        self._scheduler.restart(now_ns, now_ns)
        self.obeyed.restart()

    def add(self, command: JointCommand) -> None:
        """Schedule the next command, one tick after the one before it."""
        self._schedule(command, self.plan_ns + self._tick_ns)

    def hand_over(self, stop: StopPlan, command: JointCommand) -> None:
        """Schedule a command that takes over from a stop, after the part of the stop that is still to be written."""
        plan_ns = stop.plan_ns_at(command.t_ns)
        lead_ns = max(self.written_ns - plan_ns, 0)
        self._scheduler.delay(2 * lead_ns)  # the stop may have braked meanwhile as hard as the plan accelerated
        for between_ns in range(max(self.plan_ns, self.written_ns) + self._tick_ns, plan_ns, self._tick_ns):
            self._scheduler.add(between_ns, _with(self.command, stop.at_plan(between_ns)))
        self._schedule(command, plan_ns)

    def withdraw_grip(self) -> None:
        """Have the gripper keep what it does."""
        self._gripper.withdraw()
        self.command = replace(self.command, gripper=GripperCommand.KEEP)

    def repeat(self) -> None:
        """Write the last motion once more in the next step if there is no newer one."""
        self._again = True

    def step(self, stop: StopPlan | None, now_ns: int) -> RobotFault | None:
        """Write what is due of the commands and then of the stop; the fault if the driver fails."""
        if now_ns < self._due_ns:
            return None
        on_time = now_ns - self._due_ns < self.period_ns
        self._due_ns = (self._due_ns if on_time else now_ns) + self.period_ns
        again, self._again = self._again or self.period_ns > 0, False
        following = self._next(stop, now_ns)
        if following is None and not again:
            return None
        if following is None:
            self._scheduler.repeat(now_ns)
        last = self._last.write(following, now_ns)
        number = self.obeyed.number(last.seq)
        if stop is None:
            self._gripper.take(now_ns)  # a stop begins nothing
        return self._driver.write(JointCommand(number, now_ns, last.q, last.dq, last.ddq, self._gripper.standing))

    def settled(self, now_ns: int) -> bool:
        """Return whether a stop that has ended was written to its end, and the robot has had the time to follow."""
        if not self.written.motion.resting:
            self._settling.restart()
            return False
        return self._settling.over(now_ns)

    def _schedule(self, command: JointCommand, plan_ns: int) -> None:
        self.command, self.plan_ns = command, plan_ns
        self._gripper.note(command.gripper, command.t_ns)
        self._scheduler.add(plan_ns, command)

    def _next(self, stop: StopPlan | None, now_ns: int) -> JointCommand | None:
        if stop is None or self._scheduler.waits(now_ns):
            return self._along(now_ns) if self.period_ns else self._scheduler.take(now_ns)
        reached_ns = self._scheduler.reach(stop.plan_ns_at(now_ns), now_ns)
        return _with(self.command, stop.at_plan(reached_ns))

    def _along(self, now_ns: int) -> JointCommand | None:
        """The motion furthest along the plan that may be written now; in a straight line between two commands."""
        newest, following, fraction = self._scheduler.take_part(now_ns)
        if following is None:
            return newest
        last = newest or self.written
        return _with(last, _blend(last.motion, following.motion, fraction))


def _blend(begin: JointMotion, end: JointMotion, fraction: float) -> JointMotion:
    q, dq, ddq = (
        (1 - fraction) * a + fraction * b for a, b in ((begin.q, end.q), (begin.dq, end.dq), (begin.ddq, end.ddq))
    )
    return JointMotion(q, dq, ddq)


def _with(command: JointCommand, motion: JointMotion) -> JointCommand:
    return replace(command, q=motion.q, dq=motion.dq, ddq=motion.ddq)

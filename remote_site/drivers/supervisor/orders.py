"""Control's orders to the driver's process, and the watchdog over these orders; pure."""

from dataclasses import dataclass

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.driver import DriverSetup, JointCommand
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.reasons import Code, reason
from remote_site.safety.silence import Silence
from remote_site.safety.turn_watch import LONGEST_TURN_NS, TurnWatch

GRACE_TICKS = 3  # a command later than this finds the stop begun, and continues from within it


@dataclass(frozen=True, slots=True)
class DriverOrder:
    """An order of control: an activation when `activation` rises, a command while `run`, otherwise the stop.

    `stop_count` is the newest that control knows of; a command planned before the last stop began is ignored.
    """

    activation: int
    run: bool
    stop_count: int
    command: JointCommand


class CommandWatchdog:
    """The watch over late commands and the silence of control; pauses of this process itself do not count.

    Nor is it watched by a process that always pauses: that is a fault.
    """

    def __init__(self, setup: DriverSetup) -> None:
        self.timeout_ns = setup.command_timeout_ns
        self._grace_ns = round(GRACE_TICKS * setup.dt * NS_PER_S)
        self._silence = Silence(setup.command_timeout_ns // 2)
        self._turns = TurnWatch()
        self._order_ns = 0

    def note_order(self, now_ns: int) -> None:
        """Control ordered something: it is alive, even if its command is ignored."""
        self._order_ns = now_ns

    def silent_ns(self, command_ns: int | None, now_ns: int) -> int:
        """Time without an order, ns; 0 before the first command. To be called in every turn."""
        silent_ns = self._silence.of(max(command_ns or 0, self._order_ns), now_ns)
        return 0 if command_ns is None else silent_ns

    def slow(self, now_ns: int) -> RobotFault | None:
        """The fault of turns of this process that always take too long. To be called in every turn."""
        self._turns.note(now_ns)
        return slow_turns(self._turns.slow_ns) if self._turns.slow_ns else None

    def late(self, command_ns: int | None, now_ns: int) -> bool:
        """The last command is more than three ticks old."""
        return command_ns is not None and now_ns - command_ns > self._grace_ns


def command_timeout(silent_ns: int, limit_ns: int) -> RobotFault:
    """The fault of a control that was silent for too long."""
    why = reason(Code.COMMAND_TIMEOUT, age_ms=silent_ns / NS_PER_MS, limit_ms=limit_ns / NS_PER_MS)
    return RobotFault(FaultCode.COMMAND_TIMEOUT, why.sentence)


def slow_turns(took_ns: int) -> RobotFault:
    """The fault of a process of the driver that does not keep up."""
    why = reason(
        Code.SLOW, who="the driver's process", took_ms=took_ns / NS_PER_MS, limit_ms=LONGEST_TURN_NS / NS_PER_MS
    )
    return RobotFault(FaultCode.DEADLINE, why.sentence)

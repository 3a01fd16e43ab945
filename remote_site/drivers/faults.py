"""The faults with which a robot takes no commands: their codes, and whether it only waits to be activated."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from common.text import cut

# Characters; with code, native and the cure of `Code.FAULT` the longest sentence still fits into a message.
MOST_NATIVE, MOST_SENTENCE = 32, 320


class FaultCode(StrEnum):
    """The code of a fault; mirrored in the robot's state, stable over releases."""

    NOT_ACTIVATED = "not_activated"
    STOPPED = "stopped"
    # the robot's own
    EMERGENCY_STOP = "emergency_stop"
    ARM_POWER = "arm_power"
    WATCHDOG = "watchdog"
    BLOCKED = "blocked"
    APART = "apart"
    NOT_FINITE = "not_finite"
    ROBOT = "robot"
    # on the link to it
    SILENT = "silent"
    LINK = "link"
    REFUSED = "refused"
    # found by the driver's process
    IMPLAUSIBLE = "implausible"
    NOT_FOLLOWING = "not_following"
    COMMAND_TIMEOUT = "command_timeout"
    LIMITS = "limits"
    DEADLINE = "deadline"
    DRIVER = "driver"
    PROCESS = "process"


CALM = (FaultCode.NOT_ACTIVATED, FaultCode.STOPPED)


@dataclass(frozen=True, slots=True)
class RobotFault:
    """A fault as a code and a sentence with its cure; `native` is the robot's own number or word, "" without one.

    Both are cut, with an ellipsis, to `MOST_SENTENCE` and `MOST_NATIVE` characters.
    """

    code: FaultCode
    sentence: str
    native: str = ""

    def __post_init__(self) -> None:
        """Cut here, once: a driver may say more than memory, log and messages hold."""
        for name, most in (("sentence", MOST_SENTENCE), ("native", MOST_NATIVE)):
            text = getattr(self, name)
            if isinstance(text, str):  # anything else is named where the reading is judged
                object.__setattr__(self, name, cut(text, most))

    @property
    def calm(self) -> bool:
        """Nothing has failed: the robot waits to be activated."""
        return self.code in CALM

    def __str__(self) -> str:
        if self.calm:
            return self.sentence
        own = f" ({self.native})" if self.native else ""
        return f"{self.code.value}{own}: {self.sentence}"


NOT_ACTIVATED = RobotFault(FaultCode.NOT_ACTIVATED, "not activated yet")
STOPPED = RobotFault(FaultCode.STOPPED, "stopped, not active any more")
STILL_MOVING = RobotFault(FaultCode.REFUSED, "the arm still moves; activate it when it rests")
APART = RobotFault(FaultCode.APART, "the arm is not where it was activated; read it and activate there")


def apart(names: Sequence[str], given: Sequence[float], read: Sequence[float]) -> RobotFault:
    """The fault of an arm that is read elsewhere than it was activated, both in rad, with the joint farthest off."""
    name, wanted, found = max(zip(names, given, read, strict=True), key=lambda joint: abs(joint[2] - joint[1]))
    where = f"the arm is not where it was activated: {name} is at {found:.3f} rad, not {wanted:.3f} rad"
    return RobotFault(FaultCode.APART, f"{where}; read it and activate there")

"""A person who interrupts the conformance suite while the robot moves has it stopped first; nothing more is checked."""

from dataclasses import replace

import numpy as np
import pytest

from common.clock import FakeClock
from common.errors import DriverError, InterruptionError
from remote_site.drivers.conformance.suite import verdicts_of
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.kinematic import KinematicDriver
from tests.contracts.driver_stands import kinematic_stand

FAST_RAD_S = 0.5


class Watched(KinematicDriver):
    """Notes its calls, and whether it was sent anywhere at speed."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self.calls = list[str]()
        self.is_fast = False

    def write(self, command: JointCommand) -> JointCommand:
        self.calls.append("write")
        self.is_fast = self.is_fast or abs(command.motion.dq[0]) > FAST_RAD_S
        return super().write(command)

    def stop(self) -> None:
        self.calls.append("stop")
        super().stop()

    def deactivate(self) -> None:
        self.calls.append("deactivate")
        super().deactivate()


class Unstoppable(Watched):
    """Cannot be stopped once it is fast."""

    def stop(self) -> None:
        if self.is_fast:
            raise DriverError("no answer from the arm")
        super().stop()


def interrupted(kind: type[Watched]) -> tuple[list[Watched], list[str], str]:
    """All drivers made, all lines reported and the closing sentence of a suite interrupted at speed."""
    made, lines = list[Watched](), list[str]()

    def make(clock: FakeClock) -> Watched:
        made.append(kind(clock))
        return made[-1]

    stand = replace(kinematic_stand(make), should_stop=lambda: bool(made) and made[-1].is_fast)
    with pytest.raises(InterruptionError) as ended:
        verdicts_of(stand, lines.append)
    return made, lines, str(ended.value)


def test_the_robot_is_stopped_and_let_go_of() -> None:
    made, lines, said = interrupted(Watched)
    assert said == "interrupted; the robot was stopped and let go of"
    last = made[-1]
    first_stop = last.calls.index("stop")
    assert "write" not in last.calls[first_stop:]
    assert "deactivate" in last.calls[first_stop:]
    assert not np.abs(last.read().dq).any()
    assert not any("FAILED" in line for line in lines)


def test_a_robot_that_could_not_be_stopped_is_named_with_the_emergency_stop() -> None:
    _, _, said = interrupted(Unstoppable)
    assert said.startswith("interrupted; ")
    assert "no answer from the arm" in said
    assert said.endswith("if the robot moves, use the emergency stop")

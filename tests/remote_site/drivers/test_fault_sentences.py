"""Whatever a driver says of a fault: it is short in memory, log and messages, and what is missing is marked."""

import pytest
from structlog.testing import capture_logs

from common.messages.requests import Reply
from common.messages.wire_form import wire_form
from remote_site.drivers import simulated
from remote_site.drivers.c500c import driver as c500c
from remote_site.drivers.faults import MOST_NATIVE, MOST_SENTENCE, FaultCode, RobotFault
from remote_site.drivers.link import DriverLink
from remote_site.drivers.memory import DriverMemory
from remote_site.drivers.supervisor.orders import command_timeout
from remote_site.drivers.supervisor.reading_check import stale
from remote_site.reasons import Code, reason
from remote_site.runtime.driver_process import DriverLoop
from tests.present import present
from tests.remote_site.drivers.supervisor.supervised import LIMITS, Supervised
from tests.remote_site.spoiled_readings import drifting

LONGEST = RobotFault(max(FaultCode, key=len), 10_000 * "z", 10_000 * "7")


def test_a_long_sentence_and_a_long_native_word_end_with_an_ellipsis() -> None:
    assert LONGEST.sentence == (MOST_SENTENCE - 1) * "z" + "…"
    assert LONGEST.native == (MOST_NATIVE - 1) * "7" + "…"
    assert RobotFault(FaultCode.ROBOT, MOST_SENTENCE * "z").sentence == MOST_SENTENCE * "z"


@pytest.mark.parametrize("letter", ["z", "€", "\N{ROBOT FACE}", "\ud83e"])
def test_control_reads_what_the_drivers_process_logs(letter: str) -> None:
    rig, memory = Supervised(), DriverMemory.create(6)
    link = DriverLink(memory, LIMITS, rig.clock)
    rig.robot.trouble = RobotFault(FaultCode.ROBOT, 20_000 * letter, 50 * letter)
    rig.activate()
    rig.turns(2)
    rig.supervisor.activation = 0  # the link has not asked for any
    with capture_logs() as lines:
        rig.clock.advance_ms(2)
        DriverLoop(rig.supervisor, memory, rig.clock).turn()
    fault = present(link.read().fault)
    assert fault == rig.supervisor.fault
    assert [line["reason"] for line in lines if line["event"] == "robot fault"] == [fault.sentence]
    assert len(fault.sentence) == MOST_SENTENCE
    assert fault.sentence.endswith("…")
    assert fault.native.endswith("…")


def test_what_a_driver_raises_is_cut_too() -> None:
    rig = Supervised().activate()
    rig.robot.raises["read"] = RuntimeError(10_000 * "z")
    rig.turn()
    assert rig.fault().sentence.startswith("the driver's read raised RuntimeError: zzz")
    assert rig.fault().sentence.endswith("z…")


def test_a_long_sentence_does_not_hide_that_the_robot_does_not_stop() -> None:
    rig = Supervised().activate()
    rig.robot.raises = {"read": RuntimeError(10_000 * "z"), "stop": RuntimeError("no power")}
    rig.turn()
    assert rig.fault().sentence.endswith("z…; nor does it stop: the driver's stop raised RuntimeError: no power")


def test_the_longest_fault_is_told_with_its_cure() -> None:
    why = reason(Code.FAULT, cause=LONGEST).sentence
    sent = wire_form(Reply).pack(Reply(id=1, done=False, code="fault", reason=why))
    assert any(isinstance(field, str) and field.endswith("z…; reset it, then engage") for field in sent)


SILENT = stale(300_000_000, 100_000_000)
TIMEOUT = command_timeout(60_000_000, 50_000_000)
OWN = [RobotFault(*told) for told in (*simulated.FAULTS.values(), *c500c.FAULTS.values())]


@pytest.mark.parametrize("fault", [SILENT, TIMEOUT, *OWN], ids=str)
def test_the_cure_is_said_once(fault: RobotFault) -> None:
    why = reason(Code.FAULT, cause=fault).sentence
    assert why.endswith("; reset it, then engage")
    assert why.count("reset") == 1


def test_an_arm_that_does_not_follow_is_said_once_and_its_cure_once() -> None:
    rig = Supervised().moving()
    rig.robot.spoil = drifting(0.5)
    rig.commands(100)
    why = reason(Code.FAULT, cause=rig.fault()).sentence
    assert why.startswith("not_following: joint")
    assert why.count("follow") == 1
    assert why.endswith("; find out what holds the arm; reset it, then engage")

"""The names of an FR3's errors are libfranka's, each has a fault, and what the process shares with the driver fits."""

import numpy as np
import pytest

from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.franka.arm_memory import ArmMemory, ArmStatus
from remote_site.drivers.franka.robot_errors import ERRORS, MODES, fault_of, mode_fault


def test_no_error_is_no_fault() -> None:
    assert fault_of(()) is None
    assert mode_fault("Idle") is None
    assert mode_fault("Move") is None


@pytest.mark.parametrize("name", ERRORS)
def test_each_error_is_named_in_full_with_its_cure(name: str) -> None:
    fault = fault_of([name])
    assert fault is not None
    assert fault.sentence.startswith(f"{name}: ")
    assert not fault.calm


def test_what_is_more_than_the_robots_own_affair_comes_first() -> None:
    fault = fault_of(["power_limit_violation", "communication_constraints_violation"], "success rate 0.7")
    assert fault is not None
    assert fault.code is FaultCode.LINK
    assert fault.sentence.startswith("power_limit_violation, communication_constraints_violation: too many commands")
    assert fault.sentence.endswith("(success rate 0.7)")


def test_an_unknown_error_of_a_newer_robot_is_named_too() -> None:
    fault = fault_of(["brand_new_violation"])
    assert fault is not None
    assert (fault.code, fault.native) == (FaultCode.ROBOT, "brand_new_violation")


def test_the_status_crosses_memory_whole() -> None:
    memory, q = ArmMemory(), np.arange(7.0)
    for fault, obeyed in ((None, None), (RobotFault(FaultCode.BLOCKED, "ä sentence", "joint_reflex"), 12)):
        memory.report(ArmStatus(5, 3, True, obeyed, q, -q, fault))
        status = memory.status
        assert (status.t_ns, status.activation, status.active, status.obeyed_seq) == (5, 3, True, obeyed)
        assert np.array_equal(status.q, q)
        assert np.array_equal(status.dq, -q)
        assert status.fault == fault


def test_the_names_are_the_librarys() -> None:
    library = pytest.importorskip("pylibfranka", reason="no pylibfranka: make franka")
    assert {name for name in dir(library.Errors) if not name.startswith("_")} == set(ERRORS)
    assert set(MODES) | {"Idle", "Move"} == set(library.RobotMode.__members__)

"""An arm whose methods wait: one thread makes its calls, one at a time, and no call of the driver waits for them."""

import threading
import time
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from common.errors import DriverError
from common.host_clock import MonotonicClock
from common.messages.robot import GripperCommand
from lab.stage.waiting import until
from remote_site.drivers.driver import JointCommand
from remote_site.drivers.position_arm.arm import PositionArm, PositionArmWithGripper
from remote_site.drivers.position_arm.calls import ArmCallError
from remote_site.drivers.position_arm.driver import PositionArmDriver
from tests.contracts.driver_stands import SETUP

PATIENCE_S = 5.0


class WaitingArm(PositionArm):
    """Waits for its robot in each call, and for a gate where it is closed."""

    joints = 6
    rate_hz = 100.0
    threaded = True

    def __init__(self) -> None:
        self.calls, self.threads = list[tuple[Any, ...]](), set[int]()
        self.at_once, self.most_at_once = 0, 0
        self.gates = {name: threading.Event() for name in ("read", "write", "stop", "close")}
        for gate in self.gates.values():
            gate.set()
        self.raises, self.read_ns = dict[str, Exception](), list[tuple[int, int]]()

    def read(self):
        begun_ns = time.monotonic_ns()
        self._wait("read")
        self.read_ns.append((begun_ns, time.monotonic_ns()))
        return np.zeros(6)

    def write(self, positions):
        self._wait("write", positions[0])

    def stop(self):
        self._wait("stop")

    def close(self):
        self._wait("close")

    def _wait(self, name, *given):
        self.at_once += 1
        self.most_at_once = max(self.most_at_once, self.at_once)
        self.threads.add(threading.get_ident())
        self.calls.append((name, *given))
        time.sleep(0.002)
        self.gates[name].wait()
        self.at_once -= 1
        if name in self.raises:
            raise self.raises[name]


class WaitingGripperArm(WaitingArm, PositionArmWithGripper):
    """The same with a gripper, which does not wait."""

    def open_gripper(self):
        self.calls.append(("open",))

    def close_gripper(self, most_n):
        self.calls.append(("close_gripper", most_n))

    def gripper_opening_m(self):
        return 0.04


def reads(driver):
    try:
        return driver.read()
    except DriverError:
        return None


@pytest.fixture
def arm(request):
    arm = getattr(request, "param", WaitingArm)()
    yield arm
    for gate in arm.gates.values():
        gate.set()


@pytest.fixture
def driver(arm):
    driver = PositionArmDriver(arm, MonotonicClock())
    driver.configure(SETUP)
    until(lambda: reads(driver))
    yield driver
    for gate in arm.gates.values():
        gate.set()
    arm.raises.clear()
    driver.deactivate()


def command(seq, q, gripper=GripperCommand.KEEP):
    return JointCommand(seq, time.monotonic_ns(), np.full(6, q), np.zeros(6), np.zeros(6), gripper)


def test_one_thread_of_its_own_makes_all_calls(arm, driver):
    driver.activate(np.zeros(6))
    for seq in range(1, 30):
        driver.write(command(seq, seq / 1000))
        time.sleep(0.003)
    until(lambda: driver.read().obeyed_seq == 29)
    driver.stop()
    until(lambda: ("stop",) in arm.calls)
    assert arm.most_at_once == 1
    assert threading.get_ident() not in arm.threads
    assert len(arm.threads) == 1


def test_no_call_waits_for_the_robot_and_the_newest_command_goes_first(arm, driver):
    driver.activate(np.zeros(6))
    arm.gates["read"].clear()
    until(lambda: arm.at_once)
    begun = time.monotonic()
    for seq in (1, 2, 3):
        driver.write(command(seq, seq / 1000))
        driver.read()
    assert time.monotonic() - begun < PATIENCE_S  # the gate is closed
    assert driver.read().obeyed_seq is None
    arm.gates["read"].set()
    until(lambda: driver.read().obeyed_seq == 3)
    assert [call[1] for call in arm.calls if call[0] == "write"] == [0.003]


def test_after_a_call_that_was_slow_the_arm_is_sent_no_further_at_once(arm, driver):
    driver.activate(np.zeros(6))
    arm.gates["read"].clear()
    until(lambda: arm.at_once)
    for seq in range(1, 30):
        driver.write(command(seq, 0.005 * seq))
    arm.gates["read"].set()
    for seq in range(30, 60):
        driver.write(command(seq, 0.145))
        time.sleep(0.003)
    until(lambda: ("write", 0.145) in arm.calls)
    sent = [0.0, *(call[1] for call in arm.calls if call[0] == "write")]
    assert np.diff(sent).max() <= SETUP.limits.velocity.min() / arm.rate_hz * 1.0001


def test_a_reading_that_does_not_come_back_keeps_its_stamp(arm, driver):
    arm.gates["read"].clear()
    until(lambda: arm.at_once)
    reads(driver)
    t_ns = driver.read().t_ns
    time.sleep(0.1)
    assert driver.read().t_ns == t_ns


def test_a_stop_replaces_the_command_that_waits(arm, driver):
    driver.activate(np.zeros(6))
    driver.write(command(1, 0.01))
    driver.stop()
    until(lambda: ("stop",) in arm.calls)
    after = arm.calls[arm.calls.index(("stop",)) :]
    time.sleep(0.05)
    assert ("write", 0.01) not in after
    with pytest.raises(DriverError, match="activate the arm"):
        driver.write(command(2, 0.02))


def test_a_stop_behind_a_call_that_does_not_return_says_so_and_comes_when_it_does(arm, driver):
    driver.activate(np.zeros(6))
    arm.gates["write"].clear()
    driver.write(command(1, 0.01))
    until(lambda: ("write", 0.01) in arm.calls)
    begun = time.monotonic()
    driver.stop()
    assert time.monotonic() - begun < PATIENCE_S
    time.sleep(0.1)
    with pytest.raises(DriverError, match=r"WaitingArm\.write has not returned for \d+ ms"):
        driver.stop()
    with pytest.raises(DriverError, match="not been stopped yet"):
        driver.activate(np.zeros(6))
    arm.gates["write"].set()
    until(lambda: ("stop",) in arm.calls)


@pytest.mark.parametrize("arm", [WaitingGripperArm], indirect=True)
@pytest.mark.parametrize("writes_stop", [False, True])
def test_what_the_gripper_is_ordered_behind_a_call_that_does_not_return_is_withdrawn_by_a_stop(
    arm, driver, writes_stop
):
    arm.writes_stop = writes_stop
    driver.activate(np.zeros(6))
    arm.gates["write"].clear()
    driver.write(command(1, 0.001, GripperCommand.OPEN))
    until(lambda: ("write", 0.001) in arm.calls)
    driver.stop()
    arm.gates["write"].set()
    until(lambda: reads(driver) and ("stop",) in arm.calls)
    until(lambda: arm.calls[-1] == ("read",))
    assert ("open",) not in arm.calls


@pytest.mark.parametrize("arm", [WaitingGripperArm], indirect=True)
def test_of_what_the_gripper_is_ordered_behind_a_call_the_newest_is_done(arm, driver):
    driver.activate(np.zeros(6))
    arm.gates["read"].clear()
    until(lambda: arm.at_once)
    for seq, gripper in enumerate((GripperCommand.OPEN, GripperCommand.CLOSED), 1):
        driver.write(command(seq, 0.0, gripper))
    arm.gates["read"].set()
    until(lambda: driver.read().obeyed_seq == 2)
    until(lambda: arm.calls[-1] == ("read",))
    assert [call[0] for call in arm.calls if "open" in call[0] or "gripper" in call[0]] == ["close_gripper"]


@pytest.mark.parametrize("error", [OSError("no answer"), SystemExit(3)])
def test_what_the_thread_meets_is_raised_by_read_with_the_methods_name(arm, driver, error):
    arm.raises["read"] = error
    expected = (ArmCallError, SystemExit)

    def raised():
        try:
            driver.read()
        except expected as found:
            return str(found)
        return None

    until(raised)
    assert raised() in ("WaitingArm.read raised OSError: no answer", "3")
    arm.raises.clear()
    until(lambda: raised() is None)


def test_a_stop_that_fails_is_raised_and_repeated(arm, driver):
    arm.raises["stop"] = OSError("no answer")
    with pytest.raises(ArmCallError, match=r"WaitingArm\.stop raised OSError"):
        driver.stop()
    until(lambda: arm.calls.count(("stop",)) > 3)
    arm.raises.clear()
    count = arm.calls.count(("stop",))
    until(lambda: arm.calls[-1] == ("read",))
    assert arm.calls.count(("stop",)) <= count + 1


def test_an_arm_that_cannot_be_written_its_stop_is_stopped_and_written_no_more(arm, driver):
    arm.writes_stop = True
    driver.activate(np.zeros(6))
    driver.write(JointCommand(1, 0, np.zeros(6), np.full(6, 0.8), np.zeros(6), GripperCommand.KEEP))
    until(lambda: driver.read().obeyed_seq == 1)
    arm.raises["write"], before = OSError("no answer"), len(arm.calls)
    driver.stop()

    def is_stopped():
        with suppress(ArmCallError):
            driver.read()
        return ("stop",) in arm.calls

    until(is_stopped)
    after = len(arm.calls)
    until(lambda: len(arm.calls) > after + 5 and reads(driver))
    assert len([call for call in arm.calls[before:] if call[0] == "write"]) <= 2  # of the ten of the stop
    assert set(arm.calls[after:]) == {("read",)}


def test_the_end_waits_for_the_stop_and_the_close(arm, driver):
    arm.gates["read"].clear()
    until(lambda: arm.at_once)
    threading.Timer(0.1, arm.gates["read"].set).start()
    driver.deactivate()
    assert [call for call in arm.calls if call != ("read",)] == [("stop",), ("close",)]


def test_an_arm_that_no_thread_has_called_is_let_go_of_all_the_same():
    arm = WaitingArm()
    PositionArmDriver(arm, MonotonicClock()).deactivate()
    assert arm.calls == [("close",)]


def test_an_end_that_a_call_keeps_waiting_is_an_error(arm, driver):
    arm.gates["read"].clear()
    until(lambda: arm.at_once)
    with pytest.raises(DriverError, match=r"WaitingArm\.read has not returned"):
        driver.deactivate()


def test_readings_are_stamped_before_the_robot_is_asked(arm, driver):
    stamps = set()
    until(lambda: stamps.add(driver.read().t_ns) or len(stamps) > 20)
    assert not [t_ns for t_ns in stamps for begun_ns, ended_ns in arm.read_ns if begun_ns < t_ns < ended_ns]

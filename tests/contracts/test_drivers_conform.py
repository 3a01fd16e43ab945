"""Every driver of the house passes every check of the conformance suite; a bad one fails the check made for it."""

import threading
from dataclasses import replace

import numpy as np
import pytest

from common.clock import NS_PER_MS
from common.errors import DriverError
from remote_site.drivers.conformance.checks import CHECKS
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, JointCommand, RobotReading
from remote_site.drivers.faults import FaultCode, RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from tests.contracts.driver_stands import c500c_stand, kinematic_stand, simulated_stand

NAMES = [check.__name__ for check in CHECKS]


@pytest.mark.parametrize("check", CHECKS, ids=NAMES)
@pytest.mark.parametrize("stand", [kinematic_stand, simulated_stand, c500c_stand])
def test_the_drivers_of_the_house_pass(stand, check):
    lines = []
    assert run_checks(stand(), lines.append, [check]) == [], lines


@pytest.mark.parametrize("stand", [simulated_stand, c500c_stand])
def test_one_robot_passes_all_checks_one_after_the_other(stand):
    lines, same = [], stand()
    assert run_checks(same, lines.append, [*CHECKS, *CHECKS]) == [], lines


def test_the_a465_passes_with_lost_bytes():
    lines = []
    assert run_checks(c500c_stand(loss=0.0005), lines.append) == [], lines


class Hasty(KinematicDriver):
    """Takes commands without an activation."""

    def write(self, command: JointCommand) -> JointCommand:
        return command if self._sent is None else super().write(command)


class AnyRobot(KinematicDriver):
    """Declares that it moves six joints, but takes any model."""

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(1000.0, 6, gripper=False, force=False, watchdog_ms=None)


class Prophet(KinematicDriver):
    """Its readings are of the future."""

    def read(self) -> RobotReading:
        reading = super().read()
        return RobotReading(
            reading.t_ns + 5 * NS_PER_MS, reading.q, reading.dq, None, reading.fault, reading.obeyed_seq
        )


class Liar(KinematicDriver):
    """Reads zeros where nothing has been measured."""

    def read(self) -> RobotReading:
        if self._sent is None:
            return RobotReading(self._clock.now_ns(), np.zeros(6), np.zeros(6), None, None, None)
        return super().read()


class Feeler(KinematicDriver):
    """Feels a grip without a gripper."""

    def read(self) -> RobotReading:
        reading = super().read()
        grip = GripperReading(0.05, 12.0)
        return RobotReading(reading.t_ns, reading.q, reading.dq, grip, reading.fault, reading.obeyed_seq)


class Eager(KinematicDriver):
    """Runs ahead of its commands, and so beyond its target."""

    def write(self, command: JointCommand) -> JointCommand:
        ahead = JointCommand(
            command.seq, command.t_ns, command.q + 0.1 * command.dq, command.dq, command.ddq, command.gripper_open
        )
        super().write(ahead)
        return command


class Racer(KinematicDriver):
    """Moves one and a half times as far, so as fast, as it was commanded."""

    def activate(self, q0) -> None:
        super().activate(q0)
        self.home = np.array(q0)

    def write(self, command: JointCommand) -> JointCommand:
        q = self.home + 1.5 * (command.q - self.home)
        super().write(JointCommand(command.seq, command.t_ns, q, 1.5 * command.dq, command.ddq, command.gripper_open))
        return command


class Drifter(KinematicDriver):
    """Keeps its last speed when it should stop."""

    def _motion(self, sent: JointCommand):
        motion = super()._motion(sent)
        if self._stop_ns is None:
            return motion
        elapsed = (self._clock.now_ns() - self._stop_ns) / 1e9
        return type(motion)(sent.q + elapsed * sent.dq, sent.dq, motion.ddq)


class Restarter(KinematicDriver):
    """Restarts its stop at every call."""

    def stop(self) -> None:
        if self._sent is not None:
            self._stop_ns = self._clock.now_ns()


class Sleepwalker(KinematicDriver):
    """Takes no command slower than half a radian per second once it is faster, and keeps its last speed."""

    def write(self, command: JointCommand) -> JointCommand:
        if self._sent is not None and abs(self._sent.dq[0]) > 0.5 > abs(command.dq[0]):
            return command
        return super().write(command)

    def stop(self) -> None:
        return

    def _motion(self, sent: JointCommand):
        elapsed = (self._clock.now_ns() - sent.t_ns) / 1e9
        return type(sent.motion)(sent.q + elapsed * sent.dq, sent.dq, sent.ddq)


class Unwatched(KinematicDriver):
    """Claims a watchdog that it has not."""

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(1000.0, None, gripper=False, force=False, watchdog_ms=100.0)


class Slow(KinematicDriver):
    """Waits for its robot in every reading."""

    def read(self) -> RobotReading:
        self._clock.advance_ms(60 if self._obeyed else 0)
        return super().read()


class Broken(KinematicDriver):
    """Raises what it likes."""

    def configure(self, setup: DriverSetup) -> None:
        raise KeyError(setup)


class Deaf(KinematicDriver):
    """Is never ready."""

    def read(self) -> RobotReading:
        reading = super().read()
        fault = RobotFault(FaultCode.ROBOT, "no", native="E7")
        return RobotReading(reading.t_ns, reading.q, reading.dq, None, fault, None)


class Refuser(KinematicDriver):
    """Takes no command at all."""

    def write(self, command: JointCommand) -> JointCommand:
        raise DriverError(f"not today: {command.seq}")


class Blocked(KinematicDriver):
    """Waits for ever for its robot to take a command."""

    gate = threading.Event()

    def write(self, command: JointCommand) -> JointCommand:
        self.gate.wait()
        return super().write(command)


@pytest.fixture(autouse=True, scope="module")
def _opened_in_the_end():
    yield
    Blocked.gate.set()


class Numb(KinematicDriver):
    """Measures no speed."""

    def read(self) -> RobotReading:
        return replace(super().read(), dq=np.zeros(6))


class Mirrored(KinematicDriver):
    """Moves every second joint in the wrong direction."""

    home = np.zeros(6)

    def activate(self, q0) -> None:
        super().activate(q0)
        self.home = np.array(q0)

    def write(self, command: JointCommand) -> JointCommand:
        ways = np.array([1, -1, 1, -1, 1, -1])
        q = self.home + ways * (command.q - self.home)
        super().write(replace(command, q=q, dq=ways * command.dq, ddq=ways * command.ddq))
        return command


class Freezer(KinematicDriver):
    """Comes to rest instantly when it is stopped."""

    def stop(self) -> None:
        if self._stop_ns is None and self._sent is not None:
            self._sent = replace(self._sent, dq=np.zeros(6), ddq=np.zeros(6))
        super().stop()


class Skipper(KinematicDriver):
    """Declares 500 commands a second, and in motion passes on one in ten."""

    count = 0

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(500.0, None, gripper=False, force=False, watchdog_ms=None)

    def write(self, command: JointCommand) -> JointCommand:
        self.count += 1
        if self._stop_ns is None and command.dq.any() and self.count % 10:
            return command
        return super().write(command)


@pytest.mark.parametrize(
    ("bad", "check"),
    [
        (Hasty, "life_cycle"),
        (Broken, "life_cycle"),
        (Deaf, "life_cycle"),
        (AnyRobot, "other_robot"),
        (Prophet, "read_never_invents"),
        (Liar, "read_never_invents"),
        (Feeler, "read_never_invents"),
        (Eager, "follows"),
        (Refuser, "follows"),
        (Racer, "limits"),
        (Drifter, "stop"),
        (Restarter, "idempotent_stop"),
        (Sleepwalker, "command_timeout"),
        (Unwatched, "watchdog"),
        (Slow, "deadline"),
        (Blocked, "deadline"),
        (Numb, "read_never_invents"),
        (Mirrored, "follows"),
        (Freezer, "stop"),
        (Skipper, "rate"),
    ],
)
def test_a_bad_driver_fails_the_check_made_for_it(bad, check):
    lines = []
    checks = [c for c in CHECKS if c.__name__ == check]
    assert run_checks(kinematic_stand(bad), lines.append, checks, call_s=1.0) == [check]
    assert lines[0].startswith("FAILED")


def test_every_check_has_its_bad_driver():
    marks = test_a_bad_driver_fails_the_check_made_for_it.pytestmark
    assert {check for _, check in marks[0].args[1]} == set(NAMES)


@pytest.mark.parametrize(
    ("bad", "check"), [(Numb, "read_never_invents"), (Mirrored, "follows"), (Freezer, "stop"), (Skipper, "rate")]
)
def test_a_driver_that_lies_in_one_thing_fails_in_nothing_else(bad, check):
    lines = []
    assert run_checks(kinematic_stand(bad), lines.append) == [check], lines


def refuse_to_be_made(clock):  # noqa: ARG001  # as drivers are made
    raise TypeError("an argument is missing")


class Ceased(KinematicDriver):
    """Takes no commands a second."""

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(0.0, None, gripper=False, force=False, watchdog_ms=None)


class Portless(KinematicDriver):
    """Finds no port, and reports that."""

    def configure(self, setup: DriverSetup) -> None:  # noqa: ARG002  # as drivers are configured
        raise DriverError("the port is not there; plug it in")


class Quitter(KinematicDriver):
    """Ends the program."""

    def configure(self, setup: DriverSetup) -> None:  # noqa: ARG002  # as drivers are configured
        raise SystemExit(3)


@pytest.mark.parametrize(
    ("bad", "sentence"),
    [
        (refuse_to_be_made, "its construction raised TypeError: an argument is missing"),
        (Ceased, "its construction is refused: rate_hz is 0.0"),
        (Portless, "configure is refused: the port is not there; plug it in"),
        (Broken, "configure raised KeyError"),
        (Quitter, "configure raised SystemExit: 3"),
        (Deaf, "not ready 5 s after its activation: robot (E7): no"),
        (Blocked, "deadline: write did not return"),
    ],
)
def test_what_no_check_can_do_without_is_said_once(bad, sentence):
    lines = []
    assert run_checks(kinematic_stand(bad), lines.append, call_s=1.0) == ["life_cycle"]
    assert len(lines) == 2
    assert sentence in lines[0]


class Thief(KinematicDriver):
    """Keeps its readings to itself."""

    def read(self) -> RobotReading:
        super().read()
        return None


def test_a_call_that_returns_the_wrong_thing_is_named():
    lines = []
    run_checks(kinematic_stand(Thief), lines.append)
    assert "the driver's read raised TypeError: it returned None, not a RobotReading" in lines[0]


def test_a_watchdog_that_a_driver_has_not_is_skipped():
    lines = []
    run_checks(kinematic_stand(), lines.append)
    assert [line.split()[1] for line in lines if line.startswith("skipped")] == ["other", "watchdog"]


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_no_robot_has_is_refused(rate_hz):
    with pytest.raises(DriverError, match="rate_hz"):
        Capabilities(rate_hz, None, gripper=False, force=False, watchdog_ms=None)

"""Drivers that break the contract, each in one thing."""

import threading
from dataclasses import replace
from typing import NoReturn

import numpy as np

from common.clock import NS_PER_MS, FakeClock
from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.driver import Capabilities, DriverSetup, GripperReading, JointCommand, RobotReading
from remote_site.drivers.faults import APART, FaultCode, RobotFault
from remote_site.drivers.kinematic import KinematicDriver
from remote_site.kinematics.joints import JointMotion


class Hasty(KinematicDriver):
    """Takes commands although nobody has activated it."""

    def write(self, command: JointCommand) -> JointCommand:
        return command if self._sent is None else super().write(command)


class AnyRobot(KinematicDriver):
    """Says that it moves six joints, but takes any model."""

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


class Stuck(KinematicDriver):
    """Measures once, and hands out that reading for ever."""

    first: RobotReading | None = None

    def read(self) -> RobotReading:
        reading = super().read()
        self.first = self.first or reading
        return replace(self.first, fault=reading.fault)


class Laggard(KinematicDriver):
    """Follows a tenth of a second later than it declares."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self._before: list[RobotReading] = []

    def read(self) -> RobotReading:
        self._before.append(super().read())
        then = next(each for each in self._before if each.t_ns >= self._before[-1].t_ns - 100 * NS_PER_MS)
        return replace(self._before[-1], q=then.q, dq=then.dq)


class Feeler(KinematicDriver):
    """Feels a grip without a gripper."""

    def read(self) -> RobotReading:
        reading = super().read()
        grip = GripperReading(0.05, 12.0)
        return RobotReading(reading.t_ns, reading.q, reading.dq, grip, reading.fault, reading.obeyed_seq)


class Eager(KinematicDriver):
    """Goes on ahead of what it was commanded, and so beyond its target."""

    def write(self, command: JointCommand) -> JointCommand:
        ahead = JointCommand(
            command.seq, command.t_ns, command.q + 0.1 * command.dq, command.dq, command.ddq, command.gripper
        )
        super().write(ahead)
        return command


class Racer(KinematicDriver):
    """Moves one and a half times as far, so as fast, as it was commanded."""

    def activate(self, q0: Array) -> None:
        super().activate(q0)
        self.home = np.array(q0)

    def write(self, command: JointCommand) -> JointCommand:
        q = self.home + 1.5 * (command.q - self.home)
        super().write(JointCommand(command.seq, command.t_ns, q, 1.5 * command.dq, command.ddq, command.gripper))
        return command


class Drifter(KinematicDriver):
    """Goes on at its last speed when it should stop."""

    def _motion(self, sent: JointCommand) -> JointMotion:
        motion = super()._motion(sent)
        if self._stop_ns is None:
            return motion
        elapsed = (self._clock.now_ns() - self._stop_ns) / 1e9
        return JointMotion(sent.q + elapsed * sent.dq, sent.dq, motion.ddq)


class Restarter(KinematicDriver):
    """Begins its stop again at every call."""

    def stop(self) -> None:
        if self._sent is not None:
            self._stop_ns = self._clock.now_ns()


class Sleepwalker(KinematicDriver):
    """Takes no command slower than half a radian per second once it is faster, and goes on at its last speed."""

    def write(self, command: JointCommand) -> JointCommand:
        if self._sent is not None and abs(self._sent.dq[0]) > 0.5 > abs(command.dq[0]):
            return command
        return super().write(command)

    def stop(self) -> None:
        return

    def _motion(self, sent: JointCommand) -> JointMotion:
        elapsed = (self._clock.now_ns() - sent.t_ns) / 1e9
        return JointMotion(sent.q + elapsed * sent.dq, sent.dq, sent.ddq)


class Unwatched(KinematicDriver):
    """Claims a watchdog that it has not."""

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(1000.0, None, gripper=False, force=False, watchdog_ms=100.0)


class Slow(KinematicDriver):
    """Waits for its robot in every reading."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self._fake_clock = clock

    def read(self) -> RobotReading:
        self._fake_clock.advance_ms(60 if self._obeyed else 0)
        return super().read()


class SlowToStop(KinematicDriver):
    """Waits for its robot when it stops."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self._fake_clock = clock

    def stop(self) -> None:
        self._fake_clock.advance_ms(80 if self._stop_ns is None else 0)
        super().stop()


class SlowFreezer(SlowToStop):
    """Stands still at once when it has waited for its robot."""

    def stop(self) -> None:
        if self._stop_ns is None and self._sent is not None:
            self._sent = replace(self._sent, dq=np.zeros(6), ddq=np.zeros(6))
        super().stop()


class SlowTwice(Slow):
    """Waits for its robot in every command, too."""

    def write(self, command: JointCommand) -> JointCommand:
        self._fake_clock.advance_ms(55)
        return super().write(command)


class Hiccup(KinematicDriver):
    """Takes long for one command, the fiftieth in motion."""

    count = 0

    def __init__(self, clock: FakeClock) -> None:
        super().__init__(clock)
        self._fake_clock = clock

    def write(self, command: JointCommand) -> JointCommand:
        self.count += bool(command.dq.any())
        self._fake_clock.advance_ms(70 if self.count == 50 else 0)
        return super().write(command)


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


class Numb(KinematicDriver):
    """Measures no speed."""

    def read(self) -> RobotReading:
        return replace(super().read(), dq=np.zeros(6))


class Mirrored(KinematicDriver):
    """Moves every second joint the wrong way."""

    home = np.zeros(6)

    def activate(self, q0: Array) -> None:
        super().activate(q0)
        self.home = np.array(q0)

    def write(self, command: JointCommand) -> JointCommand:
        ways = np.array([1, -1, 1, -1, 1, -1])
        q = self.home + ways * (command.q - self.home)
        super().write(replace(command, q=q, dq=ways * command.dq, ddq=ways * command.ddq))
        return command


class UnlikeInSign(KinematicDriver):
    """Sends two joints with another sign than it reads them with."""

    ways = np.array([1, -1, -1, 1, 1, 1])

    def activate(self, q0: Array) -> None:
        super().activate(self.ways * q0)

    def write(self, command: JointCommand) -> JointCommand:
        super().write(replace(command, q=self.ways * command.q, dq=self.ways * command.dq))
        return command


class Displaced(KinematicDriver):
    """Its robot refuses to be activated where it was read."""

    def read(self) -> RobotReading:
        reading = super().read()
        return replace(reading, fault=APART) if self._sent is not None else reading


class Freezer(KinematicDriver):
    """Stands still at once when it is stopped."""

    def stop(self) -> None:
        if self._stop_ns is None and self._sent is not None:
            self._sent = replace(self._sent, dq=np.zeros(6), ddq=np.zeros(6))
        super().stop()


class Skipper(KinematicDriver):
    """Says that it takes 500 commands a second, and in motion passes on one in ten."""

    count = 0

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(500.0, None, gripper=False, force=False, watchdog_ms=None)

    def write(self, command: JointCommand) -> JointCommand:
        self.count += 1
        if self._stop_ns is None and command.dq.any() and self.count % 10:
            return command
        return super().write(command)


class Ceased(KinematicDriver):
    """Takes no commands a second."""

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(0.0, None, gripper=False, force=False, watchdog_ms=None)


class Portless(KinematicDriver):
    """Finds no port, and says so."""

    def configure(self, setup: DriverSetup) -> None:  # noqa: ARG002  # as drivers are configured
        raise DriverError("the port is not there; plug it in")


class Quitter(KinematicDriver):
    """Ends the program."""

    def configure(self, setup: DriverSetup) -> None:  # noqa: ARG002  # as drivers are configured
        raise SystemExit(3)


class Thief(KinematicDriver):
    """Keeps its readings to itself."""

    def read(self) -> RobotReading:
        super().read()
        return None  # type: ignore[return-value]  # as an untyped driver may


def refuse_to_be_made(clock: FakeClock) -> NoReturn:  # noqa: ARG001  # as drivers are made
    raise TypeError("an argument is missing")

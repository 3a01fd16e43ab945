"""An FR3 on a clock moved by hand: its arm follows each millisecond, its gripper, and what either refuses."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from common.clock import NS_PER_MS, FakeClock
from common.config.loading import load_config
from common.errors import DriverError
from common.geometry import Array
from remote_site.config import RemoteConfig
from remote_site.drivers.config import DRIVER_FILES, FRANKA
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.driver import DriverSetup
from remote_site.drivers.franka.arm_loop import ArmLoop
from remote_site.drivers.franka.arm_memory import ArmMemory, GripperMemory
from remote_site.drivers.franka.config import FrankaConfig
from remote_site.drivers.franka.driver import FrankaDriver
from remote_site.drivers.franka.gripper_loop import GripperLoop
from remote_site.drivers.franka.robot_port import ArmState, GripperWidth, LinkLostError, UnreachableError
from remote_site.drivers.franka.robot_watch import RobotWatch
from remote_site.runtime.driver_process import setup_of

CONFIG = load_config(RemoteConfig, DRIVER_FILES[FRANKA], ["driver.emulate=true"])
SETUP = setup_of(CONFIG)
LAG_S = 0.01
SAG = np.array([0.0, 0.004, 0.0, -0.003, 0.0, 0.002, 0.0])  # rad, by which the arm hangs below where it is held
BEGUN_NS = 77_000 * NS_PER_MS  # of the robot's own time


@dataclass
class FakeRobot:
    """A `RobotPort` and its `MotionPort`; each read is one millisecond later. `raises` is raised by the next call."""

    held: Array = field(default_factory=lambda: CONFIG.robot.start + SAG)
    mode: str = "Idle"
    errors: tuple[str, ...] = ()
    motion_errors: tuple[str, ...] = ()
    raises: dict[str, DriverError] = field(default_factory=dict)
    recovers: bool = True
    lost_ticks: int = 0
    ahead_ms: int = 0  # by which the time of the next state lies ahead
    calls: list[str] = field(default_factory=list)
    sent: list[Array] = field(default_factory=list)
    _t_ns: int = BEGUN_NS

    def __post_init__(self) -> None:
        self.q = self.held - SAG
        self.dq = np.zeros(7)

    def read(self) -> ArmState:
        self._raise("read")
        ticks, self.lost_ticks = 1 + self.lost_ticks, 0
        self._t_ns += ticks * NS_PER_MS
        for _ in range(ticks):
            before = self.q
            self.q = self.q + (self.held - SAG - self.q) * 0.001 / LAG_S
            self.dq = (self.q - before) / 0.001
        t_ns, self.ahead_ms = self._t_ns + self.ahead_ms * NS_PER_MS, 0
        return ArmState(t_ns, self.q, self.dq, self.held, self.mode, self.errors, self.motion_errors)

    def start(self) -> "FakeRobot":
        self.calls.append("start")
        self._raise("start")
        self.mode = "Move"
        return self

    def write(self, q: Array, *, finished: bool) -> None:
        self._raise("write")
        self.sent.append(q)
        self.held = q
        if finished:
            self.mode = "Idle"

    def recover(self) -> None:
        self.calls.append("recover")
        self._raise("recover")
        if self.recovers:
            self.mode, self.errors = "Idle", ()

    def _raise(self, call: str) -> None:
        if (error := self.raises.pop(call, None)) is not None:
            raise error


@dataclass
class FakeGripper:
    """A `GripperPort` whose fingers are there at once, closed on `object_m`, unless its link is `lost`."""

    opening_m: float = 0.04
    object_m: float = 0.0
    widest_m: float = 0.08
    raises: DriverError | None = None
    lost: bool = False
    calls: list[str] = field(default_factory=list)

    def connected(self) -> "FakeGripper":
        if self.lost:
            raise UnreachableError("the gripper does not answer")
        return self

    def read(self) -> GripperWidth:
        if self.lost:
            raise LinkLostError("the gripper does not answer")
        return GripperWidth(self.opening_m, self.widest_m)

    def open(self, width_m: float, speed_m_s: float) -> bool:  # noqa: ARG002  # as the protocol names it
        self._note(f"open {width_m:g}")
        self.opening_m = width_m
        return True

    def close(self, speed_m_s: float, force_n: float) -> bool:  # noqa: ARG002  # as the protocol names it
        self._note(f"close {force_n:g}")
        self.opening_m = self.object_m
        return True

    def _note(self, call: str) -> None:
        self.calls.append(call)
        if self.raises is not None:
            raise self.raises


class SteppedSide(FakeClock):
    """A `RobotSide` without processes, and the clock that takes it along, millisecond by millisecond.

    While `gripper_waits` the gripper's process does nothing, as in a call that has not returned.
    """

    def __init__(
        self, robot: FakeRobot, gripper: FakeGripper | None, connect: Callable[[], FakeRobot] | None = None
    ) -> None:
        super().__init__(NS_PER_MS * 1000)
        self.robot, self._grips, self._connect = robot, gripper, connect or (lambda: robot)
        self.arm, self.gripper = ArmMemory(), GripperMemory() if gripper is not None else None
        self.loop: ArmLoop | None = None
        self._gripper_loop: GripperLoop | None = None
        self.failed = ""
        self.ended = self.gripper_waits = False

    def start(self, setup: DriverSetup) -> None:
        now = _Now(self)
        self.loop = ArmLoop(RobotWatch(self._connect, now), self.arm, setup)
        if self._grips is not None and self.gripper is not None:
            self._gripper_loop = GripperLoop(self._grips.connected, self.gripper, now, 0.1, setup.grip_force_n)

    def failure(self) -> str:
        return self.failed

    def end(self) -> None:
        self.ended = True
        if self.loop is not None:
            self.loop.brake()

    def sleep_until_ns(self, deadline_ns: int) -> None:
        while self.time_ns < deadline_ns:
            self.time_ns += NS_PER_MS
            if self.loop is not None and not self.failed and (not self.ended or self.loop.moving):
                self.loop.turn()
            if self._gripper_loop is not None and not self.gripper_waits and self.time_ns // NS_PER_MS % 10 == 0:
                self._gripper_loop.turn()

    def pass_ms(self, ms: int) -> None:
        self.sleep_until_ns(self.time_ns + ms * NS_PER_MS)


class _Now(FakeClock):
    """The same time for the loops, which take no time themselves."""

    def __init__(self, clock: FakeClock) -> None:
        super().__init__()
        self._clock = clock

    def now_ns(self) -> int:
        return self._clock.time_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        del deadline_ns


def stepped_driver(side: SteppedSide) -> FrankaDriver:
    """A driver of the stepped robot, with a gripper where it has one."""
    return FrankaDriver(FrankaConfig(host="fake", gripper=side.gripper is not None), side, side)


def franka_stand() -> DriverStand:
    """A stand for the conformance suite; each driver connects anew to the same robot."""
    side = SteppedSide(FakeRobot(), FakeGripper())

    def make() -> FrankaDriver:
        side.arm, side.gripper, side.loop, side.ended = ArmMemory(), GripperMemory(), None, False
        return stepped_driver(side)

    return DriverStand(side, SETUP, make, CONFIG.robot.start)

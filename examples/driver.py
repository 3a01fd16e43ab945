"""A driver of an arm that takes positions, and Farhand's checks of it: python examples/driver.py"""

import numpy as np

from farhand.driver import (
    DriverHost,
    DriverSetup,
    DriverStand,
    FakeClock,
    JointLimits,
    PositionArm,
    PositionArmDriver,
    run_checks,
)

JOINTS = 6
NAMES = tuple(f"joint_{number}" for number in range(1, JOINTS + 1))
LIMITS = JointLimits(  # rad, rad/s, rad/s², rad/s³
    NAMES, np.full(6, -3.0), np.full(6, 3.0), np.full(6, 2.0), np.full(6, 8.0), np.full(6, 60.0)
)


class LibraryArm:
    """Stands for the library of a robot's maker: an arm that is at once where it is sent."""

    def __init__(self) -> None:
        self.positions = [0.0] * JOINTS


class MyArm(PositionArm):
    """Positions are in rad, in the order of the model's joints, with its signs and zeros."""

    joints, rate_hz, lag_ms, writes_stop = JOINTS, 250.0, 20.0, True

    def __init__(self, library: LibraryArm) -> None:
        self._library = library

    def read(self) -> list[float]:
        return list(self._library.positions)

    def write(self, positions: list[float]) -> None:
        self._library.positions = list(positions)

    def stop(self) -> None:
        """The arm stays where it was sent."""


def my_arm(host: DriverHost) -> PositionArmDriver:
    """My arm; an entry point of the group `farhand.drivers` names this function."""
    return PositionArmDriver(MyArm(LibraryArm()), host.clock)


if __name__ == "__main__":
    clock = FakeClock(1_000_000_000)
    setup = DriverSetup(joint_names=NAMES, limits=LIMITS, dt=0.004, command_timeout_ns=500_000_000)
    stand = DriverStand(clock, setup, lambda: my_arm(DriverHost(clock)), start=np.zeros(JOINTS))
    raise SystemExit(len(run_checks(stand, print)))

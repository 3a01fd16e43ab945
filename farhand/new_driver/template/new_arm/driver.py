"""The driver of new_arm: what Farhand asks of an arm, said in the words of the arm's own library."""

from collections.abc import Mapping

import msgspec
import numpy as np
from numpy.typing import NDArray

from farhand.driver import (
    DriverError,
    DriverHost,
    DriverSetup,
    Option,
    PositionArm,
    PositionArmDriver,
    check_joints,
    check_options,
    checked_by,
)

from .simulated_library import SimulatedLibrary


class NewArmOptions(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The keys of `driver.options`; REPLACE: what your library needs in order to connect."""

    port: str = "simulated"


class NewArm(PositionArm):
    """The arm new_arm; positions are in rad, in the order of the model's joints, with its signs and zeros."""

    joints = 6  # REPLACE: how many your arm has
    rate_hz = 100.0  # REPLACE: how many positions a second it takes, at most
    lag_ms = 60.0  # REPLACE: how much later it is where it was sent, at most; `farhand driver test` says if it is more
    writes_stop = True  # REPLACE: False if `stop` lets the arm brake by itself, within its limits
    threaded = False  # REPLACE: True if `read` and `write` together take more than 5 ms

    def __init__(self, library: SimulatedLibrary) -> None:
        self._library = library

    def configure(self, setup: DriverSetup) -> None:
        """Connect to the arm."""
        # REPLACE: a real arm is where it is, and needs no start.
        self._library.connect(np.zeros(self.joints) if setup.start is None else setup.start)

    def read(self) -> NDArray[np.float64]:
        """Read the measured joint positions; raise DriverError with what to do while the arm cannot be measured."""
        # REPLACE. Where your library hands out what it has received before, return None unless something new has come
        # since the last call, or MeasuredPositions with its time: else Farhand does not see that the link is dead.
        return self._library.measured_positions()

    def write(self, positions: NDArray[np.float64]) -> None:
        """Send the arm there, and return at once."""
        self._library.move_to(positions)  # REPLACE

    def stop(self) -> None:
        """Bring the arm to rest where it is; called in any state, again and again."""
        self._library.hold()  # REPLACE


def check_configuration(options: Mapping[str, Option], setup: DriverSetup) -> None:
    """Check what needs no arm to be found wrong: `farhand doctor` and each start ask for it first."""
    check_options(NewArmOptions, options)
    check_joints(setup, NewArm.joints)


@checked_by(check_configuration)
def new_arm(host: DriverHost) -> PositionArmDriver:
    """The arm new_arm, simulated as yet."""
    options = check_options(NewArmOptions, host.options)
    if options.port != "simulated":
        raise DriverError(f"there is no library for the port {options.port} yet")  # REPLACE: make it here
    return PositionArmDriver(NewArm(SimulatedLibrary(host.clock)), host.clock)

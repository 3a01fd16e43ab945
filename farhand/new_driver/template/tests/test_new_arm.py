"""The driver does all that Farhand expects of one, with the simulated arm on a clock that moves by itself."""

import numpy as np
import pytest
from new_arm.driver import NewArm, check_configuration, new_arm
from new_arm.simulated_library import SimulatedLibrary

from farhand.driver import (
    DriverHost,
    DriverSetup,
    DriverStand,
    FakeClock,
    JointLimits,
    PositionArmDriver,
    run_checks,
)

JOINTS = NewArm.joints
NAMES = tuple(f"joint_{number}" for number in range(1, JOINTS + 1))
LIMITS = JointLimits(  # REPLACE by those of your arm: rad, rad/s, rad/s², rad/s³
    names=NAMES,
    lower=np.full(JOINTS, -3.0),
    upper=np.full(JOINTS, 3.0),
    velocity=np.full(JOINTS, 2.0),
    acceleration=np.full(JOINTS, 8.0),
    jerk=np.full(JOINTS, 60.0),
)
SETUP = DriverSetup(joint_names=NAMES, limits=LIMITS, dt=0.004, command_timeout_ns=500_000_000)


def test_the_driver_conforms():
    clock, lines = FakeClock(1_000_000_000), []
    arm = NewArm(SimulatedLibrary(clock))
    arm.threaded = False  # a thread does not know this clock, and the simulated arm does not wait
    stand = DriverStand(clock, SETUP, lambda: PositionArmDriver(arm, clock), start=np.zeros(JOINTS))
    assert run_checks(stand, lines.append) == [], lines


def test_an_option_that_it_does_not_know_is_found_before_it_is_made():
    check_configuration({}, SETUP)
    with pytest.raises(Exception, match="did you mean port"):
        check_configuration({"prt": "simulated"}, SETUP)


def test_farhand_can_make_it():
    driver = new_arm(DriverHost(FakeClock(1_000_000_000)))
    assert driver.capabilities.joints == JOINTS

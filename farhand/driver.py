"""All that an author of a driver needs of Farhand; docs/writing-a-driver.md shows how, and promises nothing beyond.

A `PositionArm` has three methods, and `PositionArmDriver` makes it a `Driver`; whoever needs more writes a `Driver`.
A `DriverFactory` makes a `Driver` from a `DriverHost`. `check_options` checks the driver's own options, `checked_by`
declares what is checked before anything starts, `stopping` is the stop within the limits, and `run_checks` tries a
driver on a `DriverStand` in its author's tests.
"""

from common.clock import Clock, FakeClock
from common.errors import DriverError
from common.host_clock import MonotonicClock
from common.messages.robot import GripperCommand
from remote_site.drivers.checks_before_start import DriverCheck, checked_by
from remote_site.drivers.conformance.machine_pauses import machine_pauses
from remote_site.drivers.conformance.suite import run_checks
from remote_site.drivers.conformance.trial import DriverStand
from remote_site.drivers.driver import (
    Capabilities,
    Driver,
    DriverSetup,
    GripperReading,
    JointCommand,
    RobotReading,
    check_joints,
)
from remote_site.drivers.faults import NOT_ACTIVATED, STOPPED, FaultCode, RobotFault
from remote_site.drivers.position_arm.arm import MeasuredPositions, PositionArm, PositionArmWithGripper, Positions
from remote_site.drivers.position_arm.driver import PositionArmDriver
from remote_site.drivers.registry import DriverFactory, DriverHost, Option, check_options
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits, JointRange
from remote_site.safety.stopping import stopping

__all__ = [
    "NOT_ACTIVATED",
    "STOPPED",
    "Capabilities",
    "Clock",
    "Driver",
    "DriverCheck",
    "DriverError",
    "DriverFactory",
    "DriverHost",
    "DriverSetup",
    "DriverStand",
    "FakeClock",
    "FaultCode",
    "GripperCommand",
    "GripperReading",
    "JointCommand",
    "JointLimits",
    "JointMotion",
    "JointRange",
    "MeasuredPositions",
    "MonotonicClock",
    "Option",
    "PositionArm",
    "PositionArmDriver",
    "PositionArmWithGripper",
    "Positions",
    "RobotFault",
    "RobotReading",
    "check_joints",
    "check_options",
    "checked_by",
    "machine_pauses",
    "run_checks",
    "stopping",
]

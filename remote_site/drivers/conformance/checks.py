"""The checks that every driver must pass, in the order in which they run; each gets a driver of its own."""

from collections.abc import Callable

from remote_site.drivers.conformance.contract_checks import deadline, life_cycle, other_robot
from remote_site.drivers.conformance.following_checks import follows, lag, rate
from remote_site.drivers.conformance.gripper_checks import gripper, keeps_gripper, withdraws_gripper
from remote_site.drivers.conformance.reading_checks import read_never_invents, stamps
from remote_site.drivers.conformance.stop_checks import command_timeout, idempotent_stop, limits, stop, watchdog
from remote_site.drivers.conformance.trial import Trial

Check = Callable[[Trial], None]
CHECKS: tuple[Check, ...] = (
    life_cycle,
    other_robot,
    read_never_invents,
    stamps,
    follows,
    lag,
    rate,
    limits,
    stop,
    idempotent_stop,
    gripper,
    keeps_gripper,
    withdraws_gripper,
    command_timeout,
    watchdog,
    deadline,
)

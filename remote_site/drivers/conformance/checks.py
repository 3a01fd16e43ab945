"""The checks that every driver must pass, in the order in which they run; here also those of the order of its calls."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.following_checks import follows, lag, rate
from remote_site.drivers.conformance.gripper_checks import gripper, keeps_gripper, withdraws_gripper
from remote_site.drivers.conformance.reading_checks import read_never_invents, stamps
from remote_site.drivers.conformance.stop_checks import command_timeout, idempotent_stop, limits, stop, watchdog
from remote_site.drivers.conformance.trial import Skipped, TooSlow, Trial
from remote_site.drivers.driver import JointCommand


def life_cycle(trial: Trial) -> None:
    """Configure, activate, read and write, stop, deactivate: in this order only."""
    posture = trial.q0
    trial.refuses("activating it before it is configured", lambda: trial.driver.activate(posture))
    trial.configured()
    trial.refuses("a command before it is activated", lambda: trial.driver.write(_command(trial)))
    trial.activate()
    trial.move(trial.q0, 100)
    trial.driver.stop()
    trial.run(trial.lag_ms)
    trial.refuses("a command after a stop", lambda: trial.driver.write(_command(trial)))
    trial.activate()
    trial.driver.deactivate()
    trial.run(trial.lag_ms)
    trial.refuses("a command after it was deactivated", lambda: trial.driver.write(_command(trial)))


def other_robot(trial: Trial) -> None:
    """A model with another number of joints is refused."""
    joints = trial.driver.capabilities.joints
    if joints is None:
        raise Skipped("it moves any number of joints")
    names = tuple(f"other_{k}" for k in range(joints + 1))
    trial.refuses(
        f"a model with {len(names)} joints, where it declares {joints},",
        lambda: trial.driver.configure(replace(trial.setup, joint_names=names)),
    )


def deadline(trial: Trial) -> None:
    """No call takes longer than 50 ms."""
    trial.activated().in_motion()
    trial.driver.stop()
    trial.run(300)
    if trial.watch.slow:
        raise TooSlow(", ".join(map(str, trial.watch.slow.values())))


def _command(trial: Trial) -> JointCommand:
    zero = np.zeros(len(trial.q0))
    return JointCommand(trial.last_seq + 1, trial.clock.now_ns(), trial.q0, zero, zero, GripperCommand.KEEP)


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

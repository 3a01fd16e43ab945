"""What a driver's gripper must do: obey OPEN and CLOSED, and with KEEP hold whatever it holds."""

from collections.abc import Sequence

from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.trial import Failed, Skipped, Trial
from remote_site.drivers.driver import RobotReading

GRIP_MS = 2500  # to open or to close
KEEPS_MS = 400
MOVES_M = 0.002
KEEPS_M = 0.001


def gripper(trial: Trial) -> None:
    """The gripper opens and closes as commanded; it ends closed, for the next check."""
    _skip_without_gripper(trial)
    trial.activated()
    wide_m = _commanded(trial, GripperCommand.OPEN)
    narrow_m = _commanded(trial, GripperCommand.CLOSED)
    if wide_m - narrow_m < MOVES_M:
        raise Failed(
            f"the gripper is {1000 * wide_m:.1f} mm wide when commanded to open and {1000 * narrow_m:.1f} mm to close, "
            f"at least {1000 * MOVES_M:g} mm of difference is expected"
        )


def keeps_gripper(trial: Trial) -> None:
    """With KEEP no call moves the gripper, whether another driver has left it so, or it was closed or opened before."""
    _skip_without_gripper(trial)
    found = trial.configured().log[-1:]
    trial.activate()
    _keeps(trial, _opening_m(found or trial.log))
    for command in (GripperCommand.CLOSED, GripperCommand.OPEN):
        _keeps(trial, _commanded(trial, command))


def _skip_without_gripper(trial: Trial) -> None:
    if not trial.driver.capabilities.gripper:
        raise Skipped("it has no gripper")


def _opening_m(log: Sequence[RobotReading]) -> float:
    if not log or log[-1].gripper is None:
        raise Failed("its gripper is read as None, an opening is expected")
    return log[-1].gripper.opening_m


def _commanded(trial: Trial, command: GripperCommand) -> float:
    """The opening after the gripper has been commanded for long enough."""
    _rest(trial, GRIP_MS, command)
    return _opening_m(trial.log)


def _keeps(trial: Trial, opening_m: float) -> None:
    """Failed if the opening changes with KEEP, by a stop, or by an activation."""
    _rest(trial, KEEPS_MS, GripperCommand.KEEP)
    _kept(trial, opening_m, "with KEEP")
    trial.driver.stop()
    trial.run(trial.lag_ms + KEEPS_MS)
    _kept(trial, opening_m, "by a stop")
    trial.activate()
    _rest(trial, KEEPS_MS, GripperCommand.KEEP)
    _kept(trial, opening_m, "by an activation")


def _rest(trial: Trial, ms: float, command: GripperCommand) -> None:
    trial.move(trial.supervisor.commanded.motion.q, ms, command)
    trial.must_be_ready()


def _kept(trial: Trial, opening_m: float, what: str) -> None:
    now_m = _opening_m(trial.log)
    if abs(now_m - opening_m) > KEEPS_M:
        raise Failed(
            f"the gripper went from {1000 * opening_m:.1f} to {1000 * now_m:.1f} mm {what}, it is expected to stay "
            f"within {1000 * KEEPS_M:g} mm"
        )

"""Checks of a driver's gripper: it obeys OPEN and CLOSED soon or never, and with KEEP holds whatever it holds."""

from collections.abc import Sequence

from common.clock import NS_PER_MS
from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.trial import STEP_MS, Failed, Skipped, Trial
from remote_site.drivers.driver import JointCommand, RobotReading
from remote_site.kinematics.joints import JointMotion

GRIP_MS = 2500  # to open or to close
KEEPS_MS = 400
OPPOSITE = {GripperCommand.OPEN: GripperCommand.CLOSED, GripperCommand.CLOSED: GripperCommand.OPEN}
BEGINS_MS = 200  # beyond its lag: until fingers move that were told to before the stop
LATER_MS = 1000
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


def withdraws_gripper(trial: Trial) -> None:
    """What the gripper was ordered before a stop, or long ago, and has not begun, it never does."""
    _skip_without_gripper(trial)
    trial.activated()
    opening_m = {command: _commanded(trial, command) for command in OPPOSITE}
    stroke_m = abs(opening_m[GripperCommand.OPEN] - opening_m[GripperCommand.CLOSED])
    for before, command in OPPOSITE.items():
        _not_after_a_stop(trial, command, _left(trial, before))
    for before, command in OPPOSITE.items():
        _not_after_a_pause(trial, command, _left(trial, before), stroke_m)
        trial.driver.stop()
        trial.run(trial.lag_ms)
        trial.activate()


def _not_after_a_stop(trial: Trial, command: GripperCommand, opening_m: float) -> None:
    """An order that a stop follows at once: where it is not begun by then, no activation does it."""
    trial.driver.write(_order(trial, command))
    trial.driver.stop()
    trial.run(trial.lag_ms + BEGINS_MS)
    begun = _moved(trial, opening_m, KEEPS_M)
    trial.activate()
    _rest(trial, LATER_MS, GripperCommand.KEEP)
    if not begun:
        _kept(trial, opening_m, f"by an activation, as it was commanded ({command.value}) before the last stop")


def _not_after_a_pause(trial: Trial, command: GripperCommand, opening_m: float, stroke_m: float) -> None:
    """An order after which nothing calls the driver: where it was not done meanwhile, no later call does it."""
    trial.driver.write(_order(trial, command))
    since_ns = trial.clock.now_ns() + GRIP_MS * NS_PER_MS
    trial.clock.sleep_until_ns(since_ns)
    while trial.last().t_ns < since_ns and trial.clock.now_ns() - since_ns < trial.lag_ms * NS_PER_MS:
        trial.run(STEP_MS)
    done = _moved(trial, opening_m, stroke_m / 2)
    trial.run(LATER_MS)
    if not done:
        _kept(trial, opening_m, f"as it was commanded ({command.value}) {GRIP_MS} ms before, when it was not called")


def _moved(trial: Trial, opening_m: float, least_m: float) -> bool:
    """The fingers are at least so far from this opening, or move, and cannot be measured meanwhile."""
    grip = trial.last().gripper
    return grip is None or abs(grip.opening_m - opening_m) > least_m


def _left(trial: Trial, command: GripperCommand) -> float:
    """The opening after the gripper has been commanded for long enough, and is commanded nothing more."""
    _commanded(trial, command)
    _rest(trial, KEEPS_MS, GripperCommand.KEEP)
    return _opening_m(trial.log)


def _order(trial: Trial, command: GripperCommand) -> JointCommand:
    """An order to the gripper where the arm was sent last, past the supervisor, which would withdraw it as well."""
    rest = JointMotion.at_rest(trial.supervisor.written.q)
    return JointCommand(trial.last_seq + 1, trial.clock.now_ns(), rest.q, rest.dq, rest.ddq, command)


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

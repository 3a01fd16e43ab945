"""Checks of how a robot follows: every joint, as far, as soon, as often and as fast as it is commanded."""

import numpy as np

from common.clock import NS_PER_MS
from common.geometry import Array
from remote_site.drivers.conformance.expectations import REACHED_RAD, measured
from remote_site.drivers.conformance.trial import Failed, Trial
from remote_site.drivers.supervisor.following_check import FollowingCheck

STEPS = 3.0  # of the slowest of commands, rate and readings: a joint that pauses longer in motion misses commands
STEADY_MS = 250


def follows(trial: Trial) -> None:
    """Every joint goes where it is commanded and back, no further, and the robot reports which command it obeys."""
    trial.activated()
    home = trial.q0.copy()
    for goal in (trial.jog(), home):
        _goes_to(trial, goal)
    if trial.supervisor.obeyed.seq is None or trial.supervisor.obeyed.seq > trial.last_seq:
        raise Failed(
            f"obeyed_seq is {trial.last().obeyed_seq}, one of the commands that it was given, 1 to {trial.last_seq}, "
            "is expected"
        )


def lag(trial: Trial) -> None:
    """No joint follows later than is declared: each is where it was commanded within the robot's longest lag."""
    trial.activated()
    check, since = FollowingCheck(trial.driver.capabilities, trial.setup.joint_names), len(trial.log)
    check.restart(trial.q0, trial.clock.now_ns())
    trial.move(trial.jog(), 1000 + trial.lag_ms)
    worst, sentence = REACHED_RAD, ""
    for (now_ns, commanded), reading in zip(trial.commanded[since:], trial.log[since:], strict=True):
        check.note(commanded, now_ns)
        excess = float(check.excess(reading.q).max())
        if excess > worst:
            worst, sentence = excess, check.outside(reading.q)
    if sentence:
        wrong = trial.wrong_way()
        cure = "declare in lag_ms by how much later it follows"
        raise Failed(f"{wrong}; {sentence}" if wrong else f"{sentence}; {cure}")
    trial.must_be_ready()


def rate(trial: Trial) -> None:
    """Commands reach the robot as often as it declares, as far as its readings show."""
    trial.activated().in_motion()
    times, q, _ = measured(trial, trial.last().t_ns - STEADY_MS * NS_PER_MS)
    changes = times[1:][np.diff(q[:, 0]) != 0]
    pause_s = float(np.median(np.diff(changes))) if len(changes) > 1 else STEADY_MS / 1000
    allowed = STEPS * max(1 / trial.driver.capabilities.rate_hz, trial.setup.dt, float(np.median(np.diff(times))))
    if pause_s > allowed:
        raise Failed(
            f"in motion {trial.first_joint} pauses for {1000 * pause_s:.0f} ms at a time, at most "
            f"{1000 * allowed:.0f} ms is expected at the {trial.driver.capabilities.rate_hz:g} commands a second that "
            "it takes; it misses some"
        )


def _goes_to(trial: Trial, goal: Array) -> None:
    side, since = np.sign(goal - trial.q0), len(trial.log)
    trial.move(goal, 1500 + trial.lag_ms)
    trial.must_be_ready()
    q, names = trial.last().q, trial.setup.joint_names
    off, wrong = np.abs(q - goal), trial.wrong_way()
    if off.max() > REACHED_RAD:
        k = int(off.argmax())
        raise Failed(
            wrong
            or f"{names[k]} was commanded to {goal[k]:.3f} rad and is at {q[k]:.3f} rad, within {REACHED_RAD:g} "
            "rad is expected"
        )
    farthest: Array = np.max([side * reading.q for reading in trial.log[since:]], axis=0)
    k = int((farthest - side * goal).argmax())
    if farthest[k] - side[k] * goal[k] > REACHED_RAD:
        raise Failed(
            f"{names[k]} was commanded to {goal[k]:.3f} rad and went as far as {side[k] * farthest[k]:.3f} rad, at "
            f"most {REACHED_RAD:g} rad beyond is expected"
        )

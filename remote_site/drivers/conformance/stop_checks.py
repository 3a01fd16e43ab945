"""Checks of how a robot stops: when ordered to, when commands cease or break a limit, when nothing calls its driver."""

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from remote_site.drivers.conformance.expectations import (
    HOLDS_RAD,
    brakes_within_limits,
    ended_in,
    holds,
    rests,
    says_that_it_stopped,
    travelled,
)
from remote_site.drivers.conformance.joint_sentences import moved
from remote_site.drivers.conformance.trial import SPEED_RAD_S, STEP_MS, WINDOW_MS, Failed, Skipped, Trial
from remote_site.drivers.driver import RobotReading
from remote_site.drivers.faults import FaultCode
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stop_time

AGAIN_MS = 20
AFTER_MS = 200
TRIES = 5
BEYOND_RAD = 0.5  # of what the limits allow in a tick
OVER = 1.1  # what measurement and smoothing may add


def limits(trial: Trial) -> None:
    """The robot moves no faster than its limits, and a command beyond them stops it and is not written."""
    trial.activated().in_motion()
    if trial.speed() > SPEED_RAD_S * OVER:
        raise Failed(
            f"{trial.first_joint} moves at {trial.speed():.2f} rad/s, at most its limit of {SPEED_RAD_S:g} rad/s is "
            "expected"
        )
    for _ in range(TRIES):  # a busy machine may keep the command waiting until the stop has begun
        at, sent = trial.q0[0], trial.supervisor.commanded.motion
        trial.command(JointMotion(sent.q + trial.side * BEYOND_RAD, sent.dq, sent.ddq))
        if trial.supervisor.fault is not None:
            break
        trial.in_motion()
    trial.run(1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + 200)
    ended_in(trial, FaultCode.LIMITS, f"a command of {BEYOND_RAD:g} rad in one tick, beyond the limits,")
    rests(trial, "after a command beyond the limits")
    travelled(trial, at, sent, "after a command beyond the limits")


def stop(trial: Trial) -> None:
    """A stop in motion brings the robot to rest in time and near by, and no harder than its limits allow."""
    trial.activated().in_motion()
    before, sent = trial.last(), trial.supervisor.commanded.motion
    at, age_s = trial.q0[0], (trial.clock.now_ns() - before.t_ns) / NS_PER_S
    trial.driver.stop()
    trial.run(1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + 100)
    rests(trial, "after a stop")
    travelled(trial, at, sent, "after a stop")
    brakes_within_limits(trial, at, age_s, sent)
    says_that_it_stopped(trial.last(), "after a stop")


def idempotent_stop(trial: Trial) -> None:
    """A second stop, while stopping or at rest, changes nothing; only an activation moves the robot again."""
    trial.activated().in_motion()
    sent = trial.supervisor.commanded.motion
    slow_ms = 1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + WINDOW_MS
    for _ in range(round(slow_ms / AGAIN_MS)):
        trial.driver.stop()
        trial.run(AGAIN_MS)
    rests(trial, "after a stop that was repeated")
    rest = trial.q0.copy()
    trial.driver.stop()
    trial.run(200)
    holds(trial, rest, "a stop at rest")
    trial.activate()
    trial.run(200)
    holds(trial, rest, "an activation")


def command_timeout(trial: Trial) -> None:
    """When commands cease in motion the robot comes to rest, and moves again only when it is activated."""
    trial.activated().in_motion()
    at, sent = trial.q0[0], trial.supervisor.commanded.motion
    limit_ms = trial.setup.command_timeout_ns / NS_PER_MS
    trial.run(limit_ms + 1000 * stop_time(sent, trial.setup.limits) + 2 * trial.lag_ms + 100)
    ended_in(trial, FaultCode.COMMAND_TIMEOUT, "commands that ceased in motion")
    rests(trial, "after commands ceased")
    travelled(trial, at, sent, "after commands ceased")
    rest = trial.q0.copy()
    for _ in range(50):
        trial.command(JointMotion.at_rest(rest + trial.side * 0.05))
    holds(trial, rest, "commands without an activation")


def watchdog(trial: Trial) -> None:
    """A robot with a watchdog of its own comes to rest when its driver is not called any more."""
    own_ms = trial.driver.capabilities.watchdog_ms
    if own_ms is None:
        raise Skipped("it has none of its own")
    trial.activated().in_motion()
    sent = trial.supervisor.commanded.motion
    wait_ms = own_ms + 1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + 200
    trial.clock.sleep_until_ns(trial.clock.now_ns() + round(wait_ms * NS_PER_MS))
    rest = _read_alone(trial, trial.lag_ms)
    last = _read_alone(trial, AFTER_MS)
    if np.abs(last.q - rest.q).max() > HOLDS_RAD:
        raise Failed(
            f"{wait_ms:.0f} ms after the last call of its driver the robot still moved "
            f"{moved(trial.setup.joint_names, rest.q, last.q)} in {AFTER_MS} ms; its watchdog of {own_ms:g} ms is "
            "expected to have stopped it"
        )
    for reading in (rest, last):
        says_that_it_stopped(reading, "after its watchdog has stopped it")


def _read_alone(trial: Trial, ms: float) -> RobotReading:
    """The last reading of the driver after `ms` without its supervisor."""
    for _ in range(round(ms / STEP_MS)):
        trial.clock.sleep_until_ns(trial.clock.now_ns() + STEP_MS * NS_PER_MS)
        reading = trial.driver.read()
    return reading

"""Expectations of the arm's motion; each failure names the joint, what was expected, and what came."""

from collections.abc import Sequence

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array
from remote_site.drivers.conformance.joint_sentences import moved
from remote_site.drivers.conformance.trial import WINDOW_MS, Failed, Trial
from remote_site.drivers.driver import RobotReading
from remote_site.drivers.faults import FaultCode
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stop_time, stops

REACHED_RAD = 0.01
RESTS_RAD_S = 0.01
HOLDS_RAD = 0.005
OLD_S = 0.02  # at which age a reading's stamp may be the reason for what is judged
SHORT = 0.5  # of the travel of a stop within the limits: a shorter one is too hard


def rests(trial: Trial, when: str) -> None:
    """Failed if the first joint moves from now on."""
    trial.run(WINDOW_MS)
    if trial.speed() > RESTS_RAD_S:
        raise Failed(
            f"{trial.first_joint} still moves at {trial.speed():.3f} rad/s {when}, at most {RESTS_RAD_S:g} rad/s is "
            "expected"
        )


def holds(trial: Trial, since: Array, what: str) -> None:
    """Failed if any joint is elsewhere than in the posture `since` (n,) in rad."""
    if np.abs(trial.q0 - since).max() > HOLDS_RAD:
        raise Failed(
            f"{what} moved {moved(trial.setup.joint_names, since, trial.q0)}; it is expected to stay within "
            f"{HOLDS_RAD:g} rad"
        )


def travelled(trial: Trial, at: float, sent: JointMotion, when: str) -> None:
    """The first joint has moved no further from `at`, rad, than a stop and the lag of the robot allow."""
    speed = abs(float(sent.dq[0]))
    allowed = speed * (stop_time(sent, trial.setup.limits) + 2 * trial.lag_ms / 1000) + REACHED_RAD
    travel = abs(float(trial.q0[0]) - at)
    if travel > allowed:
        raise Failed(
            f"{trial.first_joint} moved on by {travel:.3f} rad {when}, from {at:.3f} to {trial.q0[0]:.3f} rad; at most "
            f"{allowed:.3f} rad is expected"
        )


def brakes_within_limits(trial: Trial, read_at: float, age_s: float, sent: JointMotion) -> None:
    """The first joint has moved at least as far since the stop as the quickest stop within its limits.

    At the stop its last reading, rad, was `age_s` old; it had moved on since, at the speed of `sent`.
    """
    needed = abs(stops(sent, trial.setup.limits)[0].end - float(sent.q[0]))
    travel = trial.side * (float(trial.q0[0]) - (read_at + float(sent.dq[0]) * age_s))
    if travel < SHORT * needed:
        raise Failed(
            f"{trial.first_joint} stopped within {max(travel, 0.0):.3f} rad where its limits need {needed:.3f} rad; "
            "let it stop within the acceleration and jerk that configure gives it" + _or_stamped_early(age_s)
        )


def _or_stamped_early(age_s: float) -> str:
    if age_s < OLD_S:
        return ""
    return (
        ", or stamp its readings with the time of the measurement (MeasuredPositions, for a position arm): by its t_ns "
        f"the last one was {1000 * age_s:.0f} ms old"
    )


def ended_in(trial: Trial, code: FaultCode, what: str) -> None:
    """Failed unless the supervisor has stopped the robot with this fault."""
    fault = trial.supervisor.fault
    if fault is None or fault.code is not code:
        got = fault if fault is not None else "no fault, it still takes commands"
        raise Failed(f"{what} ended in: {got}; the fault {code.value} is expected")


def says_that_it_stopped(reading: RobotReading, when: str) -> None:
    """Failed if the reading has no fault."""
    if reading.fault is None:
        raise Failed(f"{when} its reading has no fault, which says that it takes commands; one is expected")


def measured(trial: Trial, since_ns: int) -> tuple[Array, Array, Array]:
    """Times in s, positions and speeds of every reading from then on, each once."""
    readings: Sequence[RobotReading] = [reading for reading in trial.log if reading.t_ns >= since_ns]
    times: Array = np.array([(reading.t_ns - since_ns) / NS_PER_S for reading in readings])
    times, each = np.unique(times, return_index=True)
    return times, np.array([readings[k].q for k in each]), np.array([readings[k].dq for k in each])

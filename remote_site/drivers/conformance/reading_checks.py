"""Checks of a driver's readings: measured, stamped when they were, newer each time, and never invented."""

import numpy as np

from common.clock import NS_PER_MS
from common.errors import DriverError
from common.geometry import Array
from remote_site.drivers.conformance.expectations import REACHED_RAD, measured
from remote_site.drivers.conformance.trial import Failed, Trial
from remote_site.drivers.driver import RobotReading
from remote_site.drivers.supervisor.reading_check import ReadingCheck

NEAR_RAD = 0.5  # of where the robot is, before it is activated
OLDEST_MS = 150.0
UNLIKE = 0.3  # of a joint's travel: what smoothed speeds may miss


def read_never_invents(trial: Trial) -> None:
    """Readings are measured, newer each time, of the past; what is not measured is None, or raises."""
    trial.configure()
    before = _readable(trial)
    if before is not None:
        _near(trial, before.q)
    trial.run(300)
    trial.turn_to_the_middle()
    trial.activate()
    trial.run(200)
    first = trial.last()
    if first.obeyed_seq is not None and trial.supervisor.obeyed.seq is None:
        raise Failed(f"obeyed_seq is {first.obeyed_seq} before the first command, None is expected")
    _speeds_fit(trial)
    trial.in_motion()
    trial.must_be_ready()
    _times_rise(trial)
    _measures(trial)


def stamps(trial: Trial) -> None:
    """Readings carry the time at which they were measured, and new ones keep coming."""
    trial.activated()
    since_ns = trial.last().t_ns
    trial.in_motion()
    allowed_ns = ReadingCheck(trial.driver.capabilities, trial.setup).oldest_ns
    times = np.array([reading.t_ns for reading in trial.log if reading.t_ns >= since_ns])
    pause_ns = int(np.diff(times, append=trial.clock.now_ns()).max())
    if pause_ns > allowed_ns / 2:
        raise Failed(
            f"by its t_ns nothing was measured for {pause_ns / NS_PER_MS:.0f} ms, at most "
            f"{allowed_ns / 2 / NS_PER_MS:.0f} ms is expected; after {allowed_ns / NS_PER_MS:.0f} ms it is a fault"
        )


def _readable(trial: Trial) -> RobotReading | None:
    try:
        return trial.driver.read()
    except DriverError:
        return None


def _near(trial: Trial, q: Array) -> None:
    """Failed if a joint is read far from where the robot is before anything has been measured."""
    k = int(np.abs(q - trial.q0).argmax())
    if abs(q[k] - trial.q0[k]) > NEAR_RAD:
        raise Failed(
            f"before its activation {trial.setup.joint_names[k]} is read at {q[k]:.3f} rad, it is expected within "
            f"{NEAR_RAD:g} rad of {trial.q0[k]:.3f} rad, where it is"
        )


def _speeds_fit(trial: Trial) -> None:
    """Failed if the measured speeds of any joint do not integrate to its travel."""
    home, since_ns = trial.q0.copy(), trial.last().t_ns
    trial.move(trial.jog(), 500 + trial.lag_ms)
    trial.must_be_ready()
    times, q, dq = measured(trial, since_ns)
    summed = ((dq[1:] + dq[:-1]) / 2 * np.diff(times)[:, None]).sum(axis=0)
    travel = q[-1] - q[0]
    wrong = np.abs(summed - travel) - UNLIKE * np.abs(travel)
    if wrong.max() > REACHED_RAD:
        k = int(wrong.argmax())
        raise Failed(
            f"{trial.setup.joint_names[k]} went {travel[k]:.3f} rad, but its speeds add up to {summed[k]:.3f} rad; "
            f"{REACHED_RAD + UNLIKE * abs(travel[k]):.3f} rad of difference are allowed"
        )
    trial.move(home, 500 + trial.lag_ms)


def _times_rise(trial: Trial) -> None:
    times, now_ns = np.array([reading.t_ns for reading in trial.log]), trial.clock.now_ns()
    back_ns, age_ns = -int(np.diff(times).min()), now_ns - int(times[-1])
    if back_ns > 0:
        raise Failed(f"t_ns of a reading is {back_ns / NS_PER_MS:.3f} ms before that of the last, it is expected later")
    if age_ns < 0:
        raise Failed(f"t_ns of a reading is {-age_ns / NS_PER_MS:.3f} ms in the future, it is expected in the past")
    if age_ns > OLDEST_MS * NS_PER_MS:
        raise Failed(f"its newest reading is {age_ns / NS_PER_MS:.0f} ms old, at most {OLDEST_MS:.0f} ms is expected")


def _measures(trial: Trial) -> None:
    capabilities, reading = trial.driver.capabilities, trial.last()
    grip = reading.gripper
    if (grip is not None) is not capabilities.gripper:
        read = "None" if grip is None else f"an opening of {1000 * grip.opening_m:.1f} mm"
        raise Failed(f"it reads {read} as its gripper, but declares gripper={capabilities.gripper}")
    if grip is not None and (grip.force_n is not None) is not capabilities.force:
        read = "None" if grip.force_n is None else f"{grip.force_n:.1f} N"
        raise Failed(f"it reads {read} as its grip force, but declares force={capabilities.force}")
    for name, values, unit in (("q", reading.q, "rad"), ("dq", reading.dq, "rad/s")):
        if not np.isfinite(values).all():
            k = int(np.flatnonzero(~np.isfinite(values))[0])
            raise Failed(f"{name} of {trial.setup.joint_names[k]} is {values[k]} {unit}, a finite one is expected")

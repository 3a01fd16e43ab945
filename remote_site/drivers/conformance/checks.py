"""What every driver must do, check by check; each gets a driver of its own."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.errors import DriverError
from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.drivers.conformance.gripper_checks import gripper, keeps_gripper
from remote_site.drivers.conformance.trial import SPEED_RAD_S, STEP_MS, WINDOW_MS, Failed, Skipped, Trial
from remote_site.drivers.driver import JointCommand, RobotReading
from remote_site.drivers.faults import FaultCode
from remote_site.drivers.supervisor.following_check import FollowingCheck
from remote_site.drivers.supervisor.reading_check import ReadingCheck
from remote_site.drivers.supervisor.watched_driver import DEADLINE_NS
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.stopping import stop_time, stops

REACHED_RAD = 0.01
HOLDS_RAD = 0.005
AGAIN_MS = 20
ATTEMPTS = 5
OVER = 1.1  # what measurement and smoothing may add
UNLIKE = 0.3  # of a joint's travel: what smoothed speeds may miss
SHORT = 0.5  # of the travel of a stop within the limits: a shorter one is too hard
STEPS = 3.0  # of the slowest of commands, rate and readings: a joint that pauses longer in motion misses commands
STEADY_MS = 250


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
    trial.refuses("a model with another number of joints", lambda: _configure(trial, names))


def follows(trial: Trial) -> None:
    """Every joint goes where it is commanded and back, no further, and the robot reports which command it obeys."""
    trial.activated()
    home = trial.q0.copy()
    for goal in (trial.jog(), home):
        _goes_to(trial, goal)
    if trial.supervisor.obeyed.seq is None or trial.supervisor.obeyed.seq > trial.last_seq:
        raise Failed(f"obeyed_seq is {trial.last().obeyed_seq}, none that it was given")


def lag(trial: Trial) -> None:
    """No joint follows later than is declared: each is where it was commanded within the robot's longest lag."""
    trial.activated()
    check, since = FollowingCheck(trial.driver.capabilities, trial.setup.joint_names), len(trial.log)
    check.restart(trial.q0, trial.clock.now_ns())
    trial.move(trial.jog(), 1000 + trial.lag_ms)
    worst = np.zeros(len(trial.q0))
    for (now_ns, commanded), reading in zip(trial.commanded[since:], trial.log[since:], strict=True):
        check.note(commanded, now_ns)
        worst = np.maximum(worst, check.excess(reading.q))
    if worst.max() > REACHED_RAD:
        raise Failed(
            f"{_worst(trial, worst)} is {worst.max():.3f} rad from all that was commanded in the last "
            f"{check.lag_ns / NS_PER_MS:.0f} ms; declare in lag_ms by how much later it follows"
        )
    _healthy(trial)


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
            f"nothing was measured for {pause_ns / NS_PER_MS:.0f} ms by its t_ns, and after "
            f"{allowed_ns / NS_PER_MS:.0f} ms that is a fault"
        )


def rate(trial: Trial) -> None:
    """Commands reach the robot as often as it declares, as far as its readings show."""
    trial.activated().in_motion()
    times, q, _ = _measured(trial, trial.last().t_ns - STEADY_MS * NS_PER_MS)
    changes = times[1:][np.diff(q[:, 0]) != 0]
    pause_s = float(np.median(np.diff(changes))) if len(changes) > 1 else STEADY_MS / 1000
    allowed = STEPS * max(1 / trial.driver.capabilities.rate_hz, trial.setup.dt, float(np.median(np.diff(times))))
    if pause_s > allowed:
        raise Failed(
            f"in motion the joint pauses for {1000 * pause_s:.0f} ms at a time, {1000 * allowed:.0f} ms are "
            f"enough at the {trial.driver.capabilities.rate_hz:g} commands a second that it takes; it misses some"
        )


def limits(trial: Trial) -> None:
    """The robot moves no faster than its limits, and a command beyond them stops it and is not written."""
    trial.activated().in_motion()
    if trial.speed() > SPEED_RAD_S * OVER:
        raise Failed(f"the joint moves at {trial.speed():.2f} rad/s where {SPEED_RAD_S:g} is its limit")
    for _ in range(ATTEMPTS):  # a busy machine may keep the command waiting until the stop has begun
        at, sent = trial.q0[0], trial.supervisor.commanded.motion
        trial.command(JointMotion(sent.q + trial.side * 0.5, sent.dq, sent.ddq))
        if trial.supervisor.fault is not None:
            break
        trial.in_motion()
    trial.run(1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + 200)
    if trial.supervisor.fault is None or trial.supervisor.fault.code is not FaultCode.LIMITS:
        raise Failed(f"a command beyond the limits ended in: {trial.supervisor.fault}")
    _rests(trial, "after a command beyond the limits")
    _travelled(trial, at, sent)


def stop(trial: Trial) -> None:
    """A stop in motion brings the robot to rest in time and near by, and no harder than its limits allow."""
    trial.activated().in_motion()
    before, sent = trial.last(), trial.supervisor.commanded.motion
    at, stood_ms = trial.q0[0], (trial.clock.now_ns() - before.t_ns) / NS_PER_MS
    trial.driver.stop()
    trial.run(1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + 100)
    _rests(trial, "after a stop")
    _travelled(trial, at, sent)
    _brakes_within_limits(trial, at + float(sent.dq[0]) * stood_ms / 1000, sent)
    if trial.last().fault is None:
        raise Failed("it reports that it is ready after a stop")


def idempotent_stop(trial: Trial) -> None:
    """A second stop, while stopping or at rest, changes nothing; only an activation moves the robot again."""
    trial.activated().in_motion()
    sent = trial.supervisor.commanded.motion
    slow_ms = 1000 * stop_time(sent, trial.setup.limits) + trial.lag_ms + WINDOW_MS
    for _ in range(round(slow_ms / AGAIN_MS)):
        trial.driver.stop()
        trial.run(AGAIN_MS)
    _rests(trial, "after a stop that was repeated")
    rest = trial.q0.copy()
    trial.driver.stop()
    trial.run(200)
    if np.abs(trial.q0 - rest).max() > HOLDS_RAD:
        raise Failed("a stop at rest moved the robot")
    trial.activate()
    trial.run(200)
    if np.abs(trial.q0 - rest).max() > HOLDS_RAD:
        raise Failed("an activation moved the robot")


def read_never_invents(trial: Trial) -> None:
    """Readings are measured, newer each time, of the past; what is not measured is None, or raises."""
    trial.configure()
    before = _readable(trial)
    if before is not None and np.abs(before.q - trial.q0).max() > 0.5:
        raise Failed(f"before its activation it reads {before.q}, far from where the robot is")
    trial.run(300)
    trial.turn_to_the_middle()
    trial.activate()
    trial.run(200)
    first = trial.last()
    if first.obeyed_seq is not None and trial.supervisor.obeyed.seq is None:
        raise Failed(f"it obeys command {first.obeyed_seq}, which it was never given")
    _speeds_fit(trial)
    trial.in_motion()
    _healthy(trial)
    times = np.array([reading.t_ns for reading in trial.log])
    if (np.diff(times) < 0).any() or times[-1] > trial.clock.now_ns():
        raise Failed("the times of its readings go backwards, or lie in the future")
    if trial.clock.now_ns() - times[-1] > 150 * NS_PER_MS:
        raise Failed(f"its newest reading is {(trial.clock.now_ns() - times[-1]) / NS_PER_MS:.0f} ms old")
    _measures(trial)


def command_timeout(trial: Trial) -> None:
    """When commands cease in motion the robot comes to rest, and moves again only when it is activated."""
    trial.activated().in_motion()
    at, sent = trial.q0[0], trial.supervisor.commanded.motion
    limit_ms = trial.setup.command_timeout_ns / NS_PER_MS
    trial.run(limit_ms + 1000 * stop_time(sent, trial.setup.limits) + 2 * trial.lag_ms + 100)
    if trial.supervisor.fault is None or trial.supervisor.fault.code is not FaultCode.COMMAND_TIMEOUT:
        raise Failed(f"commands ceased, and it ended in: {trial.supervisor.fault}")
    _rests(trial, "after commands ceased")
    _travelled(trial, at, sent)
    rest = trial.q0.copy()
    for _ in range(50):
        trial.command(JointMotion.at_rest(rest + trial.side * 0.05))
    if np.abs(trial.q0 - rest).max() > HOLDS_RAD:
        raise Failed("commands moved it again without an activation")


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
    last = _read_alone(trial, 200)
    if np.abs(last.q - rest.q).max() > HOLDS_RAD:
        raise Failed(f"the robot still moves {wait_ms:.0f} ms after the last call of its driver")
    if rest.fault is None or last.fault is None:
        raise Failed("its watchdog has stopped it, but it reports that it is ready")


def deadline(trial: Trial) -> None:
    """No call takes longer than 50 ms."""
    trial.activated().in_motion()
    trial.driver.stop()
    trial.run(300)
    if trial.timer.longest_ns > DEADLINE_NS:
        raise Failed(f"a call took {trial.timer.longest_ns / NS_PER_MS:.0f} ms")


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
    command_timeout,
    watchdog,
    deadline,
)


def _command(trial: Trial) -> JointCommand:
    zero = np.zeros(len(trial.q0))
    return JointCommand(trial.last_seq + 1, trial.clock.now_ns(), trial.q0, zero, zero, GripperCommand.KEEP)


def _configure(trial: Trial, names: tuple[str, ...]) -> None:
    trial.driver.configure(replace(trial.setup, joint_names=names))


def _readable(trial: Trial) -> RobotReading | None:
    try:
        return trial.driver.read()
    except DriverError:
        return None


def _read_alone(trial: Trial, ms: float) -> RobotReading:
    """The last reading of the driver after `ms` without its supervisor."""
    for _ in range(round(ms / STEP_MS)):
        trial.clock.sleep_until_ns(trial.clock.now_ns() + STEP_MS * NS_PER_MS)
        reading = trial.driver.read()
    return reading


def _healthy(trial: Trial) -> None:
    if not trial.ready:
        raise Failed(f"it stopped: {trial.supervisor.fault}")


def _rests(trial: Trial, when: str) -> None:
    """Failed if the joint moves from now on."""
    trial.run(WINDOW_MS)
    if trial.speed() > REACHED_RAD:
        raise Failed(f"the joint still moves at {trial.speed():.3f} rad/s {when}")


def _travelled(trial: Trial, at: float, sent: JointMotion) -> None:
    """The joint has moved no further than a stop and the lag of the robot allow."""
    speed = abs(float(sent.dq[0]))
    allowed = speed * (stop_time(sent, trial.setup.limits) + 2 * trial.lag_ms / 1000) + REACHED_RAD
    travel = abs(float(trial.q0[0]) - at)
    if travel > allowed:
        raise Failed(f"the joint moved on by {travel:.3f} rad where {allowed:.3f} are enough")


def _brakes_within_limits(trial: Trial, at: float, sent: JointMotion) -> None:
    """The joint has moved at least as far since the stop as the quickest stop within its limits."""
    needed = abs(stops(sent, trial.setup.limits)[0].end - float(sent.q[0]))
    travel = trial.side * (float(trial.q0[0]) - at)
    if travel < SHORT * needed:
        raise Failed(
            f"the joint stopped within {max(travel, 0.0):.3f} rad where its limits need {needed:.3f}; it brakes too"
            " hard, so let it stop within the acceleration and jerk that configure gives it"
        )


def _goes_to(trial: Trial, goal: Array) -> None:
    side, since = np.sign(goal - trial.q0), len(trial.log)
    trial.move(goal, 1500 + trial.lag_ms)
    _healthy(trial)
    off = np.abs(trial.last().q - goal)
    if off.max() > REACHED_RAD:
        raise Failed(f"{_worst(trial, off)} is {off.max():.4f} rad from where it was commanded")
    beyond: Array = np.max([side * (reading.q - goal) for reading in trial.log[since:]], axis=0)
    if beyond.max() > REACHED_RAD:
        raise Failed(f"{_worst(trial, beyond)} went {beyond.max():.4f} rad beyond its target")


def _speeds_fit(trial: Trial) -> None:
    """Failed if the measured speeds of any joint do not integrate to its travel."""
    home, since_ns = trial.q0.copy(), trial.last().t_ns
    trial.move(trial.jog(), 500 + trial.lag_ms)
    _healthy(trial)
    times, q, dq = _measured(trial, since_ns)
    summed = ((dq[1:] + dq[:-1]) / 2 * np.diff(times)[:, None]).sum(axis=0)
    travel = q[-1] - q[0]
    wrong = np.abs(summed - travel) - UNLIKE * np.abs(travel)
    if wrong.max() > REACHED_RAD:
        k = int(wrong.argmax())
        raise Failed(f"{_worst(trial, wrong)} went {travel[k]:.3f} rad, but its speeds add up to {summed[k]:.3f} rad")
    trial.move(home, 500 + trial.lag_ms)


def _measured(trial: Trial, since_ns: int) -> tuple[Array, Array, Array]:
    """Times in s, positions and speeds of every reading from then on, each once."""
    readings = [reading for reading in trial.log if reading.t_ns >= since_ns]
    times: Array = np.array([(reading.t_ns - since_ns) / NS_PER_S for reading in readings])
    times, each = np.unique(times, return_index=True)
    return times, np.array([readings[k].q for k in each]), np.array([readings[k].dq for k in each])


def _worst(trial: Trial, off: Array) -> str:
    return trial.setup.joint_names[int(off.argmax())]


def _measures(trial: Trial) -> None:
    capabilities, reading = trial.driver.capabilities, trial.last()
    if (reading.gripper is not None) is not capabilities.gripper:
        raise Failed("it reads a gripper that it does not have, or none although it has one")
    if reading.gripper is not None and (reading.gripper.force_n is not None) is not capabilities.force:
        raise Failed("it reads a grip force that it cannot measure, or none although it can")
    if not (np.isfinite(reading.q).all() and np.isfinite(reading.dq).all()):
        raise Failed("it reads joints that are not finite")

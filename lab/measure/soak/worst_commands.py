"""Soak test: ten simulated minutes of injected faults, and the worst command of each driver against the limits."""

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import structlog

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.robot import FOLLOWING, SessionState
from lab.measure.soak.robot import c500c, kinematic, simulated
from lab.measure.soak.world import CONFIG, MakeRobot, World
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.clearance import Workspace
from remote_site.safety.collision import CollisionModel
from remote_site.safety.stopping import stop_time

Mask = npt.NDArray[np.bool_]

SECONDS = 600.0
SEED = 20
ROBOTS: dict[str, MakeRobot] = {"kinematic": kinematic, "simulated": simulated, "c500c, emulated": c500c}
TICK_NS = round(NS_PER_S / CONFIG.control.rate_hz)
MIN_INTERVAL_NS = NS_PER_MS // 100  # of commands with the same time stamp: no division by zero


@dataclass(frozen=True)
class CommandLog:
    """The k commands of a run: times (k,) in ns, and motions (k, n) in rad, rad/s and rad/s².

    `same_segment` (k - 1,) is whether a command is of the same segment of motion as the one before it.
    """

    t_ns: Array
    q: Array
    dq: Array
    ddq: Array
    same_segment: Mask

    @classmethod
    def of(cls, world: World) -> "CommandLog":
        """The commands that the world's driver received."""
        received = world.driver.received
        q, dq, ddq = (np.array([getattr(m, name) for m in received.motions]) for name in ("q", "dq", "ddq"))
        return cls(np.array(received.t_ns), q, dq, ddq, np.diff(received.segments) == 0)

    def index_at(self, t_ns: int) -> int:
        """The index of the last command received by `t_ns`; -1 before the first."""
        return int(np.searchsorted(self.t_ns, t_ns, side="right")) - 1

    def last_moving_ns(self, after_ns: int, until_ns: int) -> int | None:
        """Find when the last moving command after `after_ns` and by `until_ns` came; None when all were at rest."""
        first, end = np.searchsorted(self.t_ns, [after_ns, until_ns], side="right")
        moving = np.flatnonzero(self.dq[first:end].any(axis=1))
        return int(self.t_ns[first + moving[-1]]) if len(moving) else None


def soak(make: MakeRobot, seconds: float, seed: int = SEED) -> dict[str, float]:
    """Run one driver for simulated `seconds`; its figures by name, where a fraction of 1 is the limit itself."""
    world = World(make, seed)
    world.run(seconds)
    log = CommandLog.of(world)
    engagements, states = world.ticks.engagements, world.ticks.states
    return {
        "simulated s": seconds,
        "commands": float(len(log.t_ns)),
        "engagements": float(engagements),
        "fraction of time engaged": states.count(SessionState.ENGAGED) / len(states),
        "robot faults seen": float(sum(world.ticks.faults.values())),
        "control stalls": float(world.timer.stalls),
        "late driver calls": float(world.driver.injected["late"]),
        **{f"wire: {kind}": float(count) for kind, count in world.operator.happened.items()},
        **dynamics(world, log),
        **margins(world, log),
        "moving commands after disengagement": float(moving_while_disengaged(world, log)),
        "rest after the last obeyed sample, ms beyond the bound": rest_beyond_bound_ms(world, log),
        "oldest sample obeyed, fraction of the age limit": oldest_obeyed(world),
    }


def dynamics(world: World, log: CommandLog) -> dict[str, float]:
    """The worst speed, acceleration and jerk as fractions of the limits.

    "Between commands" is by finite differences over the times when the commands were received.
    """
    limits = world.limits
    dt_s = np.maximum(np.diff(log.t_ns), MIN_INTERVAL_NS)[:, None] / NS_PER_S
    jerk = np.diff(log.ddq, axis=0) / dt_s / limits.jerk
    speed = np.diff(log.q, axis=0) / dt_s / limits.velocity
    return {
        "values not finite": float(np.sum(~np.isfinite(np.hstack([log.q, log.dq, log.ddq])))),
        "speed, fraction of limit": _worst(log.dq / limits.velocity),
        "acceleration, fraction of limit": _worst(log.ddq / limits.acceleration),
        "jerk between commands, fraction of limit": _worst(jerk[log.same_segment]),
        "speed between commands, fraction of limit": _worst(speed[log.same_segment]),
    }


def margins(world: World, log: CommandLog) -> dict[str, float]:
    """Compute how near the commanded arm came to a collision, and how far outside its joint limits and workspace."""
    limits, safety, robot = world.limits, CONFIG.safety, CONFIG.robot
    collision = CollisionModel.from_urdf(robot.urdf, world.model, robot.capsules, safety.collision)
    workspace = Workspace(np.array(safety.workspace_min_m), np.array(safety.workspace_max_m))
    moved = np.concatenate([[True], np.diff(log.q, axis=0).any(axis=1)])
    postures, begins_segment = log.q[moved], np.concatenate([[True], np.logical_not(log.same_segment)])[moved]
    beyond = np.maximum(limits.lower - postures, postures - limits.upper)
    outside = [workspace.excess(world.model.forward(q)[:3, 3]) for q in postures]
    return {
        "minimum distance, mm": 1e3 * min(collision.distance(q) for q in postures),
        "required distance, mm": 1e3 * collision.margin,
        "joint beyond its limit, rad": float(beyond.max()),
        "tool outside the workspace, mm": 1e3 * max(outside),
        "tool further outside than when its segment began, mm": 1e3 * further_outside(outside, begins_segment),
    }


def further_outside(outside: list[float], begins_segment: Mask) -> float:
    """The most that a tool went outside the workspace beyond where its segment began, m.

    It may begin outside: the robot's own stop does not heed the workspace.
    """
    first = further = 0.0
    for excess, begin in zip(outside, begins_segment, strict=True):
        first = excess if begin else first
        further = max(further, excess - first)
    return further


def moving_while_disengaged(world: World, log: CommandLog) -> int:
    """The number of moving commands while disengaged, after the time that the stop may take."""
    ticks, moving = world.ticks, 0
    for begin, end in _runs([state not in FOLLOWING for state in ticks.states]):
        until_ns = ticks.t_ns[end] if end < len(ticks.t_ns) else int(log.t_ns[-1])
        rest_ns = _rest_ns(world, log, ticks.t_ns[begin], ticks.t_ns[begin])
        first, last = np.searchsorted(log.t_ns, [rest_ns, until_ns - 1], side="right")
        moving += int(np.sum(log.dq[first:last].any(axis=1)))
    return moving


def rest_beyond_bound_ms(world: World, log: CommandLog) -> float:
    """The worst delay, ms, between the bound on coming to rest and the last moving command; negative when in time.

    The bound is the invariant of a lost hand: T_soft after the capture of the last sample obeyed, plus two ticks, plus
    the time of the stop.
    """
    ticks, worst = world.ticks, -float("inf")
    for _, end in _runs([born > 0 for born in ticks.born_ns]):
        if end == len(ticks.t_ns):
            break
        next_obeyed = next((k for k in range(end, len(ticks.t_ns)) if ticks.born_ns[k]), len(ticks.t_ns) - 1)
        bound_ns = _rest_ns(world, log, ticks.born_ns[end - 1] + ticks.age_limit_ns[end - 1], ticks.t_ns[end - 1])
        last_ns = log.last_moving_ns(ticks.t_ns[end - 1], ticks.t_ns[next_obeyed] - 1)
        if last_ns is not None:
            worst = max(worst, (last_ns - bound_ns) / NS_PER_MS)
    return worst


def oldest_obeyed(world: World) -> float:
    """The greatest age of a sample that control obeyed, as a fraction of the limit in force then; 0 without any."""
    ticks = world.ticks
    columns = zip(ticks.t_ns, ticks.born_ns, ticks.age_limit_ns, strict=True)
    return max(((t - born) / limit for t, born, limit in columns if born), default=0.0)


def _rest_ns(world: World, log: CommandLog, onset_ns: int, motion_ns: int) -> int:
    """Compute when the arm has to be at rest, for a stop due at `onset_ns` from its motion at `motion_ns`.

    Time in which a driver call blocked is added, and one command period of a robot that is slower than control.
    """
    index = log.index_at(motion_ns)
    motion = JointMotion(log.q[index], log.dq[index], log.ddq[index])
    stop_ns = round(stop_time(motion, world.limits) * NS_PER_S) if index >= 0 else 0
    period_ns = round(NS_PER_S / world.driver.capabilities.rate_hz)
    bound_ns = onset_ns + 2 * TICK_NS + stop_ns + (period_ns if period_ns > TICK_NS else 0)
    return bound_ns + sum(end - begin for begin, end in world.driver.blocked if motion_ns <= end and begin <= bound_ns)


def _runs(flags: list[bool]) -> list[tuple[int, int]]:
    """Begin and end (exclusive) of every unbroken run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def _worst(fractions: Array) -> float:
    return float(np.abs(fractions).max(initial=0.0))


def measure() -> dict[str, float]:
    """The figures of every driver, by name."""
    quiet: Callable[..., type] = structlog.make_filtering_bound_logger
    structlog.configure(wrapper_class=quiet(logging.CRITICAL))  # the injected faults are counted instead
    return {
        f"{name}: {figure}": value for name, make in ROBOTS.items() for figure, value in soak(make, SECONDS).items()
    }

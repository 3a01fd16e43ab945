"""Ten minutes of simulated time with everything going wrong: the worst that each driver received, beside the limits."""

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import structlog

from bench.soak.robot import c500c, kinematic, simulated
from bench.soak.world import CONFIG, MakeRobot, World
from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.robot import SessionState
from remote_site.kinematics.joints import JointMotion
from remote_site.safety.clearance import Workspace
from remote_site.safety.collision import CollisionModel
from remote_site.safety.stopping import stop_time
from remote_site.session.state_machine import FOLLOWING

Mask = npt.NDArray[np.bool_]

SECONDS = 600.0
SEED = 20
ROBOTS: dict[str, MakeRobot] = {"kinematic": kinematic, "simulated": simulated, "c500c, emulated": c500c}
TICK_NS = round(NS_PER_S / CONFIG.control.rate_hz)
SOFT_NS = round(CONFIG.safety.t_soft_ms * NS_PER_MS)
EARLIEST_NS = NS_PER_MS // 100


@dataclass(frozen=True)
class Log:
    """A soak's commands as arrays: times (k,) in ns, motions (k, n), and which follow their predecessor (k - 1,)."""

    t_ns: Array
    q: Array
    dq: Array
    ddq: Array
    follows: Mask

    @classmethod
    def of(cls, world: World) -> "Log":
        """What the world's driver received."""
        received = world.driver.received
        q, dq, ddq = (np.array([getattr(m, name) for m in received.motions]) for name in ("q", "dq", "ddq"))
        return cls(np.array(received.t_ns), q, dq, ddq, np.diff(received.activations) == 0)

    def before(self, t_ns: int) -> int:
        """The number of the last command at `t_ns`, -1 before the first."""
        return int(np.searchsorted(self.t_ns, t_ns, side="right")) - 1

    def last_moving(self, after_ns: int, until_ns: int) -> int | None:
        """When the last command of a span was received that was not at rest; None when all were."""
        first, end = np.searchsorted(self.t_ns, [after_ns, until_ns], side="right")
        moving = np.flatnonzero(self.dq[first:end].any(axis=1))
        return int(self.t_ns[first + moving[-1]]) if len(moving) else None


def soak(make: MakeRobot, seconds: float, seed: int = SEED) -> dict[str, float]:
    """The figures of one driver; a share of 1 is the limit itself."""
    world = World(make, seed)
    world.run(seconds)
    log = Log.of(world)
    engagements, states = world.ticks.engagements, world.ticks.states
    return {
        "simulated s": seconds,
        "commands": float(len(log.t_ns)),
        "engagements": float(engagements),
        "share of time followed": states.count(SessionState.ENGAGED) / len(states),
        "robot faults seen": float(sum(world.ticks.faults.values())),
        "stumbles of control": float(world.timer.stumbles),
        "late calls of the driver": float(world.driver.troubles["late"]),
        **{f"wire: {kind}": float(count) for kind, count in world.operator.happened.items()},
        **dynamics(world, log),
        **clearances(world, log),
        "moving commands after a latch": float(moving_after_latch(world, log)),
        "rest after the last good sample, ms beyond the bound": rest_beyond_bound_ms(world, log),
        "oldest sample obeyed, ms": oldest_obeyed_ms(world),
    }


def dynamics(world: World, log: Log) -> dict[str, float]:
    """The worst speed, acceleration and jerk as fractions of the limits; differences of commands by their times."""
    limits = world.limits
    dt = np.maximum(np.diff(log.t_ns), EARLIEST_NS)[:, None] / NS_PER_S
    jerk = np.diff(log.ddq, axis=0) / dt / limits.jerk
    speed = np.diff(log.q, axis=0) / dt / limits.velocity
    return {
        "not finite": float(np.sum(~np.isfinite(np.hstack([log.q, log.dq, log.ddq])))),
        "speed, share of limit": _worst(log.dq / limits.velocity),
        "acceleration, share of limit": _worst(log.ddq / limits.acceleration),
        "jerk by the times, share of limit": _worst(jerk[log.follows]),
        "way by the times, share of the speed limit": _worst(speed[log.follows]),
    }


def clearances(world: World, log: Log) -> dict[str, float]:
    """The least distance of the commanded arm from anything, and how far it was outside its limits and its box."""
    limits, safety, robot = world.limits, CONFIG.safety, CONFIG.robot
    collision = CollisionModel.from_urdf(robot.urdf, world.model, robot.capsules, safety.collision)
    box = Workspace(np.array(safety.workspace_min_m), np.array(safety.workspace_max_m))
    moved = np.concatenate([[True], np.diff(log.q, axis=0).any(axis=1)])
    postures, begins = log.q[moved], np.concatenate([[True], np.logical_not(log.follows)])[moved]
    beyond = np.maximum(limits.lower - postures, postures - limits.upper)
    outside = [box.excess(world.model.forward(q)[:3, 3]) for q in postures]
    further = further_than_at_first(outside, begins)
    return {
        "least distance, mm": 1e3 * min(collision.distance(q) for q in postures),
        "margin, mm": 1e3 * collision.margin,
        "joint beyond its limit, rad": float(beyond.max()),
        "tool out of its box, mm": 1e3 * max(outside),
        "tool further out than where it was activated, mm": 1e3 * further,
    }


def further_than_at_first(outside: list[float], begins: Mask) -> float:
    """The greatest excess beyond that of an activation's first command: a robot's own stop may leave the box."""
    first = further = 0.0
    for excess, begin in zip(outside, begins, strict=True):
        first = excess if begin else first
        further = max(further, excess - first)
    return further


def moving_after_latch(world: World, log: Log) -> int:
    """Commands that move while nothing is engaged, after the time that the stop of the motion before needs."""
    ticks, moving = world.ticks, 0
    for begin, end in _runs([state not in FOLLOWING for state in ticks.states]):
        until_ns = ticks.t_ns[end] if end < len(ticks.t_ns) else int(log.t_ns[-1])
        rest_ns = _rest_ns(world, log, ticks.t_ns[begin], ticks.t_ns[begin])
        first, last = np.searchsorted(log.t_ns, [rest_ns, until_ns - 1], side="right")
        moving += int(np.sum(log.dq[first:last].any(axis=1)))
    return moving


def rest_beyond_bound_ms(world: World, log: Log) -> float:
    """The invariant: how long after T_soft, two ticks and the stop's time since the last good sample the arm moved."""
    ticks, worst = world.ticks, -float("inf")
    for _, end in _runs([born > 0 for born in ticks.born_ns]):
        if end == len(ticks.t_ns):
            break
        again = next((k for k in range(end, len(ticks.t_ns)) if ticks.born_ns[k]), len(ticks.t_ns) - 1)
        bound_ns = _rest_ns(world, log, ticks.born_ns[end - 1] + SOFT_NS, ticks.t_ns[end - 1])
        last_ns = log.last_moving(ticks.t_ns[end - 1], ticks.t_ns[again] - 1)
        worst = max(worst, ((last_ns or 0) - bound_ns) / NS_PER_MS if last_ns else worst)
    return worst


def oldest_obeyed_ms(world: World) -> float:
    """The greatest age of a sample that control obeyed."""
    ticks = world.ticks
    return max((t - born for t, born in zip(ticks.t_ns, ticks.born_ns, strict=True) if born), default=0) / NS_PER_MS


def _rest_ns(world: World, log: Log, onset_ns: int, motion_ns: int) -> int:
    """When an arm has to rest that moved as it did at `motion_ns`: the time in which a driver blocks is added.

    A slow robot's motion is known from the last command, and the period since then is added.
    """
    k = log.before(motion_ns)
    motion = JointMotion(log.q[k], log.dq[k], log.ddq[k])
    stop_ns = round(stop_time(motion, world.limits) * NS_PER_S) if k >= 0 else 0
    period_ns = round(NS_PER_S / world.driver.capabilities.rate_hz)
    bound_ns = onset_ns + 2 * TICK_NS + stop_ns + (period_ns if period_ns > TICK_NS else 0)
    return bound_ns + sum(end - begin for begin, end in world.driver.blocked if motion_ns <= end and begin <= bound_ns)


def _runs(flags: list[bool]) -> list[tuple[int, int]]:
    """Begin and end of every unbroken run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(begin), int(end)) for begin, end in edges.reshape(-1, 2)]


def _worst(fractions: Array) -> float:
    return float(np.abs(fractions).max(initial=0.0))


def measure() -> dict[str, float]:
    """All figures of all drivers."""
    quiet: Callable[..., type] = structlog.make_filtering_bound_logger
    structlog.configure(wrapper_class=quiet(logging.CRITICAL))  # the faults are made, and counted
    return {
        f"{name}: {figure}": value for name, make in ROBOTS.items() for figure, value in soak(make, SECONDS).items()
    }

"""How long the pure part of a control tick takes: mapping, inverse kinematics, follower and guard, in microseconds."""

import gc
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from rich.console import Console
from rich.table import Table

from common.clock import NS_PER_S
from common.geometry import rotation_from_vector
from remote_site.config import RemoteConfig
from remote_site.kinematics.inverse import Solution, SphericalWristInverse
from remote_site.kinematics.joints import JointMotion
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.mapping import Mapping
from remote_site.motion import Course, Follower, leash
from remote_site.safety.guard import Guard, Passed, Workspace

T = TypeVar("T")
TICKS = 5000
TICK_S = 0.004


class Chain:
    """The steps of a tick around an arm that follows a swaying hand."""

    def __init__(self) -> None:
        config = RemoteConfig()
        self.config = config
        self.model = ArmModel.from_urdf(config.robot.urdf, config.robot.tool_frame, config.robot.tool_T_tcp)
        limits = JointLimits.from_model(self.model, config.robot)
        box = Workspace(np.array(config.safety.workspace_min_m), np.array(config.safety.workspace_max_m))
        self.inverse = SphericalWristInverse(self.model, limits)
        self.guard = Guard(limits, box, self.model, TICK_S)
        self.follower = Follower(limits, TICK_S)
        self.course = Course(limits, config.control)
        self.mapping = Mapping(config.mapping)
        start = config.robot.start
        self.sent = JointMotion.at_rest(start)
        self.mapping.engage(np.zeros(3), np.eye(3), self.model.forward(start))
        self.course.reset(0, start)
        self.spent: dict[str, list[int]] = {}

    def tick(self, k: int) -> None:
        """One tick with a new hand sample in it."""
        now_ns = round(k * TICK_S * NS_PER_S)
        t = k * TICK_S
        wrist = 0.06 * np.array([np.sin(1.3 * t), np.sin(1.7 * t), np.cos(2.1 * t) - 1.5])
        turn = rotation_from_vector(0.3 * np.array([np.sin(1.1 * t), np.sin(1.9 * t), np.sin(0.7 * t)]))
        tool = self.model.forward(self.sent.q)
        target = self.timed("mapping", lambda: self.mapping.target(wrist, turn))
        leashed, _ = self.timed("leash", lambda: leash(target, tool, 0.2, 1.0))
        solution = self.timed("inverse", lambda: self.inverse.nearest(leashed, self.sent.q))
        if not isinstance(solution, Solution):
            raise SystemExit(f"the path of the benchmark is not reachable: {solution.reason.sentence}")
        self.timed("course: aim", lambda: self.course.aim(now_ns, solution.q, now_ns))
        aim = self.timed("course: at", lambda: self.course.at(now_ns))
        self.follower.reset(self.sent)
        proposed = self.timed("follower", lambda: self.follower.track(*aim))
        if not isinstance(proposed, JointMotion):
            raise SystemExit(f"the follower found no way: {proposed.sentence}")
        verdict = self.timed("guard", lambda: self.guard.check(proposed, self.sent))
        self.sent = proposed if isinstance(verdict, Passed) else self.guard.stop(self.sent)
        self.timed("stop (in place of the follower)", lambda: self.guard.stop(self.sent))

    def timed(self, name: str, step: Callable[[], T]) -> T:
        """Run a step and note its time."""
        begin = time.perf_counter_ns()
        result = step()
        self.spent.setdefault(name, []).append(time.perf_counter_ns() - begin)
        return result


def main() -> None:
    """Print the table."""
    chain = Chain()
    for k in range(200):
        chain.tick(k)
    chain.spent.clear()
    gc.disable()
    for k in range(200, 200 + TICKS):
        chain.tick(k)
    table = Table("step", "p50 µs", "p99 µs", title=f"control tick, {TICKS} ticks, each with a new sample")
    spent = {name: np.array(times) / 1e3 for name, times in chain.spent.items()}
    between = spent["course: at"] + spent["follower"] + spent["guard"]
    rows = spent | {"a tick between samples": between}
    new = [spent[name] for name in ("mapping", "leash", "inverse", "course: aim")]
    rows["a tick with a new sample"] = between + sum(new)
    for name, times in rows.items():
        table.add_row(name, *(f"{np.percentile(times, p):.1f}" for p in (50, 99)))
    Console().print(table)


if __name__ == "__main__":
    main()

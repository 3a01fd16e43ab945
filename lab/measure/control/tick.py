"""Cost of a control tick, decode to write, beside Pink with daqp on the same targets; microseconds, one run."""

import gc
import importlib
import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.geometry import Array
from common.link.channels import HAND
from common.messages.codec import decode, encode
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from lab.stage.processes import PIP, UnavailableError, run_quietly
from lab.stage.stepped.kinematic_loop import KinematicLoop
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.session.lease import Holder, Lease, LeaseStatus
from remote_site.session.samples import NamedSample

TICKS = 4000
TICK_NS = 4 * NS_PER_MS
TICKS_PER_SAMPLE = 8
WARM_UP = 500
BLOCK = 125  # ticks of each in turn: in a control process none shares its caches with another
TCP = "tool_centre_point"
PINK = Path("build") / "pink"  # a folder of its own, without our dependencies
PINK_PACKAGES = ("pin-pink==4.4.0", "qpsolvers", "loop-rate-limiters")
INSTALL_S = 120.0
LEVELS = (50, 99)
LEASE = 1
OPERATOR = "bench"


class Bench:
    """One arm's pipeline and driver behind encoded samples of a swaying hand, tick by tick."""

    def __init__(self, config: RemoteConfig) -> None:
        self._clock = FakeClock(TICK_NS)
        self.loop = KinematicLoop(config, self._clock)
        self._lease = LeaseStatus(Lease(LEASE, Holder(1, OPERATOR), TICKS * TICK_NS))
        self.targets: dict[int, Array] = {}
        self.spent: dict[str, list[int]] = {"with a new sample": [], "between samples": [], "all": []}

    def tick(self, k: int) -> None:
        """Decode, validate, map, inverse kinematics, collision, Ruckig, guard, write; timed after the warm-up."""
        self._clock.advance_ms(TICK_NS / NS_PER_MS)
        new = k % TICKS_PER_SAMPLE == 0
        payload = encode(_swaying_hand(k, self._clock.now_ns() - TICK_NS)) if new else b""
        begin_ns = time.perf_counter_ns()
        samples = (NamedSample(OPERATOR, decode(payload, HandArm, HAND.max_bytes)),) if payload else ()
        command = self.loop.cycle(self._lease, samples)
        spent_ns = time.perf_counter_ns() - begin_ns
        self.targets[k] = command.snapshot.target
        if k > WARM_UP:
            self.spent["all"].append(spent_ns)
            self.spent["with a new sample" if new else "between samples"].append(spent_ns)


class Pink:
    """One arm with a frame and a posture task, solved one tick at a time; UnavailableError states why not."""

    def __init__(self, model: pin.Model, frame: str, q: Array, dt: float) -> None:
        if not PINK.exists():
            run_quietly([sys.executable, *PIP, "--no-deps", "--target", str(PINK), *PINK_PACKAGES], INSTALL_S)
        if str(PINK) not in sys.path:
            sys.path.append(str(PINK))
        try:
            self._pink, tasks = importlib.import_module("pink"), importlib.import_module("pink.tasks")
        except ImportError as error:
            raise UnavailableError(str(error)) from error
        self._configuration: Any = self._pink.Configuration(model, model.createData(), q.copy())
        self._frame = tasks.FrameTask(frame, position_cost=1.0, orientation_cost=0.3)
        self._posture = tasks.PostureTask(cost=1e-3)
        self._posture.set_target(q)
        self._dt = dt

    def step(self, base_T_target: Array) -> None:
        """Solve and integrate one tick towards a pose (4 x 4)."""
        self._frame.set_target(pin.SE3(base_T_target))
        tasks = [self._frame, self._posture]
        velocity = self._pink.solve_ik(self._configuration, tasks, self._dt, solver="daqp", safety_break=False)
        self._configuration.integrate_inplace(velocity, self._dt)


def measure() -> dict[str, float]:
    """p50 and p99 in µs: our whole tick with the closed form, with the general solver, and Pink's solution alone."""
    general = RemoteConfig(robot=RobotConfig(kinematics="general"))
    benches = {"closed form": Bench(RemoteConfig()), "general solver": Bench(general)}
    model, start = benches["closed form"].loop.model, RemoteConfig().robot.start
    pink: Pink | None = None
    try:
        pink = Pink(model.pin_model, TCP, start, TICK_NS / NS_PER_S)
    except UnavailableError as error:
        print(f"Pink skipped: {error}")
    theirs: list[int] = []
    gc.disable()
    try:
        for begin in range(1, TICKS, BLOCK):
            block = range(begin, min(begin + BLOCK, TICKS))
            for bench in benches.values():
                for k in block:
                    bench.tick(k)
            if pink is not None:
                theirs += _timed(pink, block, benches["closed form"].targets)
    finally:
        gc.enable()
    figures = {f"{name}, {kind}": times for name, bench in benches.items() for kind, times in bench.spent.items()}
    if pink is not None:
        figures["Pink with daqp, its solution alone"] = theirs
    levels = {
        f"{name}, p{level} µs": float(np.percentile(times, level)) / 1e3
        for name, times in figures.items()
        for level in LEVELS
    }
    return {"Pink measured": float(pink is not None)} | levels


def _timed(pink: Pink, block: range, targets: dict[int, Array]) -> list[int]:
    """Measure how long Pink takes for each of these ticks, ns, after the warm-up."""
    spent = []
    for k in block:
        begin_ns = time.perf_counter_ns()
        pink.step(targets[k])
        spent.append(time.perf_counter_ns() - begin_ns)
    return spent if block.start > WARM_UP else []


def _swaying_hand(seq: int, capture_ns: int) -> HandArm:
    t = capture_ns / NS_PER_S
    x, y, z = 0.06 * math.sin(1.3 * t), 0.06 * math.sin(1.7 * t), 0.3 - 0.05 * (1 - math.cos(2.1 * t))
    return HandArm(
        session=1,
        seq=seq,
        capture_ns=capture_ns,
        elbow=None,
        wrist=(x, y, z),
        index=(x + 0.02, y - 0.17, z),
        thumb=(x - 0.05, y - 0.1, z + 0.01),
        status=TrackingStatus.TRACKED,
        reason="",
        thumb_inferred=False,
        hand_open=False,
        gripper_toggles=0,
        lease=LEASE,
        clock=ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=capture_ns),
    )

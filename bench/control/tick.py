"""What a control tick costs, decode to write, beside Pink with daqp on the same targets; microseconds, one run."""

import gc
import math
import time

import numpy as np

from bench.control.pink_ik import Pink
from bench.installing import UnavailableError
from common.clock import NS_PER_MS, NS_PER_S, FakeClock
from common.geometry import Array
from common.link.channels import HAND
from common.messages.codec import decode, encode
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from remote_site.config import RemoteConfig
from remote_site.kinematics.config import RobotConfig
from remote_site.kinematics.model import ArmModel
from remote_site.runtime.kinematic_loop import KinematicLoop
from remote_site.session.lease import Holder, Lease, LeaseStatus

TICKS = 4000
TICK_NS = 4 * NS_PER_MS
TICKS_PER_SAMPLE = 8
WARM_UP = 500
BLOCK = 125  # ticks of each in turn: in a control process none shares its caches with another
TCP = "tool_centre_point"
LEVELS = (50, 99)
LEASE = 1


class Bench:
    """One arm's pipeline and driver behind encoded samples of a swaying hand, tick by tick."""

    def __init__(self, config: RemoteConfig) -> None:
        self._clock = FakeClock(TICK_NS)
        self.loop = KinematicLoop(config, self._clock)
        self._lease = LeaseStatus(Lease(LEASE, Holder(1, "bench"), TICKS * TICK_NS))
        self.targets: dict[int, Array] = {}
        self.spent: dict[str, list[int]] = {"with a new sample": [], "between samples": [], "all": []}

    def tick(self, k: int) -> None:
        """Decode, validate, map, inverse kinematics, collision, Ruckig, guard, write; timed after the warm-up."""
        self._clock.advance_ms(TICK_NS / NS_PER_MS)
        new = k % TICKS_PER_SAMPLE == 0
        payload = encode(_swaying_hand(k, self._clock.now_ns() - TICK_NS)) if new else b""
        begin_ns = time.perf_counter_ns()
        samples = (decode(payload, HandArm, HAND.max_bytes),) if payload else ()
        command = self.loop.cycle(self._lease, samples)
        spent_ns = time.perf_counter_ns() - begin_ns
        self.targets[k] = command.snapshot.target
        if k > WARM_UP:
            self.spent["all"].append(spent_ns)
            self.spent["with a new sample" if new else "between samples"].append(spent_ns)


def measure() -> dict[str, float]:
    """p50 and p99 in µs: our whole tick with the closed form, with the general solver, and Pink's solution alone."""
    general = RemoteConfig(robot=RobotConfig(kinematics="general"))
    benches = {"closed form": Bench(RemoteConfig()), "general solver": Bench(general)}
    pink, why = _pink(benches["closed form"].loop.model, RemoteConfig().robot.start)
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
    if pink is None:
        print(f"Pink skipped: {why}")
    else:
        figures["Pink with daqp, its solution alone"] = theirs
    return {"Pink measured": float(pink is not None)} | _levels(figures)


def _timed(pink: Pink, block: range, targets: dict[int, Array]) -> list[int]:
    """What Pink takes for each of these ticks, ns, after the warm-up."""
    spent = []
    for k in block:
        begin_ns = time.perf_counter_ns()
        pink.step(targets[k])
        spent.append(time.perf_counter_ns() - begin_ns)
    return spent if block.start > WARM_UP else []


def _levels(figures: dict[str, list[int]]) -> dict[str, float]:
    return {
        f"{name}, p{level} µs": float(np.percentile(times, level)) / 1e3
        for name, times in figures.items()
        for level in LEVELS
    }


def _pink(model: ArmModel, start: Array) -> tuple[Pink | None, str]:
    try:
        return Pink(model.pin_model, TCP, start, TICK_NS / NS_PER_S), ""
    except UnavailableError as error:
        return None, str(error)


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

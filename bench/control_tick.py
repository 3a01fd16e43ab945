"""What the pure part of a control tick costs: the whole chain, with and without a new hand sample, in microseconds."""

import gc
import time

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.messages import ClockSync, HandArm, TrackingStatus
from remote_site.chain import Chain
from remote_site.config import RemoteConfig
from remote_site.kinematics.limits import JointLimits
from remote_site.kinematics.model import ArmModel
from remote_site.lease import Holder, LeaseDesk

TICKS = 6000
TICK_NS = 4 * NS_PER_MS
TICKS_PER_SAMPLE = 8
WARM_UP = 500
LEASE = 1


def measure() -> dict[str, float]:
    """p50 and p99 in µs of a tick, without and with a new sample, while the arm follows a swaying hand."""
    config = RemoteConfig()
    model = ArmModel.from_urdf(config.robot.urdf, config.robot.tool_frame, config.robot.tool_T_tcp)
    leases = LeaseDesk(TICKS * TICK_NS, LEASE)
    leases.acquire(Holder(1, "bench"), 0)
    chain = Chain(config, model, JointLimits.from_model(model, config.robot), config.robot.start, leases)
    spent: dict[bool, list[int]] = {True: [], False: []}
    gc.disable()
    try:
        for k in range(1, TICKS):
            new_sample = k % TICKS_PER_SAMPLE == 0
            elapsed_ns = _tick(chain, k, new_sample=new_sample)
            if k > WARM_UP:
                spent[new_sample].append(elapsed_ns)
    finally:
        gc.enable()
    names = {True: "with a new sample", False: "between samples"}
    return {
        f"{names[new]}, p{level} µs": float(np.percentile(times, level)) / 1e3
        for new, times in spent.items()
        for level in (50, 99)
    }


def _tick(chain: Chain, k: int, *, new_sample: bool) -> int:
    now_ns = k * TICK_NS
    sample = _swaying_hand(k, now_ns - TICK_NS) if new_sample else None
    begin_ns = time.perf_counter_ns()
    if sample is not None:
        chain.receive(sample, now_ns)
    step = chain.tick(now_ns, chain.robot(ready=True, fault=""))
    elapsed_ns = time.perf_counter_ns() - begin_ns
    chain.sent = step.motion
    return elapsed_ns


def _swaying_hand(seq: int, capture_ns: int) -> HandArm:
    t = capture_ns / NS_PER_S
    x, y, z = 0.06 * np.sin(1.3 * t), 0.06 * np.sin(1.7 * t), 0.3 - 0.05 * (1 - np.cos(2.1 * t))
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

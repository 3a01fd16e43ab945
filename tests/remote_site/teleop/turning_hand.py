"""A simulated operator who turns the hand while the thumb is hidden a third of the time, through both sites' code."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from common.clock import NS_PER_S
from common.geometry import Array, angle_between, hand_rotation
from common.messages.hand import ClockSync, HandArm, TrackingStatus
from common.messages.robot import SessionState
from local_site.samples.hand_sample import HandSampler, OpenHand
from local_site.samples.smoothing import SmoothingConfig, make_smoother
from local_site.simulation.body import ArmBody
from local_site.simulation.config import BodyConfig, MotionConfig, MotionName
from local_site.simulation.motion import Motion
from local_site.tracking.tracker import ArmEstimate
from tests.remote_site.remote_loop import LEASE, START_NS, TICK_NS, RemoteLoop

TICKS_PER_SAMPLE = 8  # 31 samples a second
STILL_S = 3.0  # for the engagement
HIDDEN_S, PERIOD_S = 1.0, 3.0
SEEN_SIGMA_M, INFERRED_SIGMA_M = 0.0027, 0.01  # along each axis, as the tracker of bare hands reports them
NOISE_M = 0.0003
Spoil = Callable[[ArmEstimate], ArmEstimate]


@dataclass(frozen=True, slots=True)
class Turned:
    """One sample's outcome: its time since the hand began to turn, and what the tool lacks of the hand's rotation."""

    t_s: float
    hidden: bool
    error_deg: float
    tool_deg_s: float


def estimates(name: MotionName, seconds: float, seed: int) -> Iterator[tuple[ArmEstimate, ArmEstimate]]:
    """What a tracker finds, and what it would find with the thumb always seen, sample by sample.

    A hidden thumb is off by one error of `INFERRED_SIGMA_M` for as long as it is hidden; all points are noisy.
    """
    motion, body = Motion(MotionConfig(name=name, still_s=STILL_S), BodyConfig(), seed), ArmBody(BodyConfig())
    rng = np.random.default_rng(seed)
    off, was_hidden = np.zeros(3), False
    for k in range(math.ceil((STILL_S + seconds) * NS_PER_S / (TICKS_PER_SAMPLE * TICK_NS))):
        t_ns = k * TICKS_PER_SAMPLE * TICK_NS
        t_s = t_ns / NS_PER_S
        hidden = is_hidden(t_s)
        if hidden and not was_hidden:
            off = rng.normal(0.0, INFERRED_SIGMA_M, 3)
        was_hidden = hidden
        truth = body.truth(motion.pose(t_s))
        points = {n: getattr(truth, n) + rng.normal(0.0, NOISE_M, 3) for n in ("elbow", "wrist", "index", "thumb")}
        seen = {n: SEEN_SIGMA_M**2 * np.eye(3) for n in points}
        clean = ArmEstimate(START_NS + t_ns, TrackingStatus.TRACKED, "", **points, covariances=seen)
        spoilt = replace(
            clean,
            thumb=points["thumb"] + off,
            thumb_inferred=True,
            covariances=seen | {"thumb": INFERRED_SIGMA_M**2 * np.eye(3)},
        )
        yield (spoilt if hidden else clean), clean


def is_hidden(t_s: float) -> bool:
    """Whether the thumb is hidden: in the middle third of each period, once the hand turns."""
    since_s = t_s - STILL_S
    return since_s >= 0.0 and PERIOD_S - HIDDEN_S <= 2.0 * (since_s % PERIOD_S) < PERIOD_S + HIDDEN_S


def followed(name: MotionName, seconds: float, seed: int, spoil: Spoil = lambda estimate: estimate) -> list[Turned]:
    """Smoothed, sent and followed by the pipeline: the target's rotation since the engagement against the hand's."""
    loop, sampler = RemoteLoop(), HandSampler(7)
    smoother, of_clean = (make_smoother(SmoothingConfig()) for _ in range(2))
    origins: tuple[Array, Array] | None = None
    found: list[Turned] = []
    last = loop.model.forward(loop.sent.q)[:3, :3]
    for estimate, clean in estimates(name, seconds, seed):
        hand = _shown(of_clean.smooth(clean))
        loop.tick(_sample(sampler, smoother.smooth(spoil(estimate))))
        for _ in range(TICKS_PER_SAMPLE - 1):
            loop.tick()
        tool, engagement = loop.snapshot.target[:3, :3], loop.snapshot.engagement
        if engagement is None:
            continue
        if origins is None:
            origins = hand, tool
        assert loop.snapshot.state is SessionState.ENGAGED
        t_s = (estimate.t_ns - START_NS) / NS_PER_S
        base_R_operator = np.array(loop.config.mapping.base_R_operator)
        meant = base_R_operator @ hand @ origins[0].T @ base_R_operator.T @ origins[1]
        speed = math.degrees(angle_between(last, tool)) * NS_PER_S / (TICKS_PER_SAMPLE * TICK_NS)
        last = tool
        found.append(Turned(t_s - STILL_S, is_hidden(t_s), math.degrees(angle_between(meant, tool)), speed))
    return found


def _shown(estimate: ArmEstimate) -> Array:
    points = (np.asarray(getattr(estimate, name)) for name in ("wrist", "index", "thumb"))
    rotation = hand_rotation(*points)
    assert rotation is not None
    return rotation


def _sample(sampler: HandSampler, estimate: ArmEstimate) -> HandArm:
    clock = ClockSync(remote_minus_local_ns=0, uncertainty_ns=0, measured_ns=estimate.t_ns)
    return sampler.sample(estimate, OpenHand(), LEASE, clock, None, estimate.t_ns)

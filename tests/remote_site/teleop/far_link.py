"""A hand over an emulated far link on stepped time: delay, jitter, loss and cuts, seeded; and what the arm does."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from random import Random

import numpy as np
from msgspec.structs import replace

from common.clock import NS_PER_MS, NS_PER_S
from common.messages.hand import ClockSync, HandArm
from common.messages.requests import EngagementAction
from common.messages.robot import SessionState
from lab.stage.network.in_transit import InTransit
from remote_site.config import RemoteConfig
from tests.remote_site.remote_loop import TICK_NS, Point, RemoteLoop, hand

PERIOD_NS = NS_PER_S // 30
TRACKING_NS = 15 * NS_PER_MS
Motion = Callable[[float], Point]  # the wrist's position in m after so many seconds


def circle(t_s: float, radius_m: float = 0.04, hz: float = 0.3) -> Point:
    """A circle across and up."""
    angle = 2 * math.pi * hz * t_s
    return radius_m * math.sin(angle), 0.0, 0.3 + radius_m * (1 - math.cos(angle))


@dataclass(frozen=True)
class FarLink:
    """A link that delays, spreads and loses samples, in order; `cuts` are its interruptions, s to s.

    After `longer` (s, ms) the delay is another one; what is known of the clock becomes less certain by and by.
    """

    delay_ms: float
    jitter: float = 0.0
    loss: float = 0.0
    cuts: tuple[tuple[float, float], ...] = ()
    longer: tuple[float, float] = (math.inf, 0.0)
    seed: int = 7

    def delay_at(self, t_s: float) -> float:
        """The mean delay in ms."""
        return self.delay_ms if t_s < self.longer[0] else self.longer[1]

    def uncertainty_ns(self, t_s: float) -> int:
        """Of the clock's offset: the delay, reached at 2 ms a second."""
        risen_ms = 2.0 * max(t_s - self.longer[0], 0.0)
        return round(min(self.delay_ms + risen_ms, max(self.delay_at(t_s), self.delay_ms)) * NS_PER_MS)

    def sent(self, seconds: float, motion: Motion) -> InTransit[HandArm]:
        """The samples under way; their times, that of capture too, are in ns from the start."""
        rng, coming = Random(self.seed), InTransit[HandArm]()  # noqa: S311  # a link, not secrets
        for k in range(int(seconds * NS_PER_S / PERIOD_NS)):
            capture_ns = k * PERIOD_NS
            sent_s = (capture_ns + TRACKING_NS) / NS_PER_S
            delay_ms = self.delay_at(sent_s) * (1 + self.jitter * rng.uniform(-1, 1))
            lost = rng.random() < self.loss or any(begin <= sent_s < end for begin, end in self.cuts)
            if not lost:
                arrives_ns = capture_ns + TRACKING_NS + round(delay_ms * NS_PER_MS)
                uncertainty_ns = self.uncertainty_ns(sent_s)
                clock = ClockSync(remote_minus_local_ns=0, uncertainty_ns=uncertainty_ns, measured_ns=0)
                sample = hand(k + 1, capture_ns, motion(capture_ns / NS_PER_S), clock=clock)
                coming.send(sample, arrives_ns)
        return coming


@dataclass
class Run:
    """What the arm did: per tick its state and tool, and the changes between engaged and holding, in s."""

    loop: RemoteLoop
    begun_ns: int = 0
    tools: list[Point] = field(default_factory=list)
    limits_ms: list[float] = field(default_factory=list)
    states: list[SessionState] = field(default_factory=list)

    @property
    def changes_s(self) -> list[float]:
        """When the state changed."""
        pairs = pairwise(self.states)
        return [k * TICK_NS / NS_PER_S for k, (one, other) in enumerate(pairs, 1) if one is not other]

    @property
    def holds(self) -> int:
        """How often the arm began to wait."""
        pairs = pairwise(self.states)
        return sum(one is SessionState.ENGAGED and other is SessionState.HOLDING for one, other in pairs)

    @property
    def followed(self) -> float:
        """The fraction of the time in which the arm followed."""
        return self.states.count(SessionState.ENGAGED) / len(self.states)

    def most_changes(self, within_s: float) -> int:
        """The greatest number of changes within this time."""
        times = self.changes_s
        return max((sum(t <= other < t + within_s for other in times) for t in times), default=0)

    def error_mm(self, motion: Motion, lag_s: float, from_s: float = 0.0) -> float:
        """The tool's rms distance from where the hand was `lag_s` before, apart from their constant offset.

        It counts `from_s` after the run began.
        """
        rotation = np.array(self.loop.config.mapping.base_R_operator)
        t = (np.arange(len(self.tools)) * TICK_NS + self.begun_ns) / NS_PER_S - lag_s
        asked = np.array([motion(s) for s in t]) @ rotation.T
        off = (np.array(self.tools) - asked)[round(from_s * NS_PER_S / TICK_NS) :]
        off = off - off.mean(axis=0)
        return 1e3 * float(np.sqrt((off**2).sum(axis=1).mean()))


def engaged_over(link: FarLink, seconds: float, motion: Motion = circle, config: RemoteConfig | None = None) -> Run:
    """Engage over the link after 3 s, and follow for `seconds`; the clock is as uncertain as the link is long."""
    loop = RemoteLoop(config)
    start_ns = loop.clock.now_ns()
    coming, run = link.sent(seconds + 3.0, motion), Run(loop)
    while coming.next_ns is not None:
        elapsed_ns = loop.clock.now_ns() - start_ns
        samples = [on_clock(sample, start_ns, loop.lease) for sample in coming.arrived(elapsed_ns)]
        loop.tick(*samples)
        _record(run, loop, elapsed_ns)
    return run


def on_clock(sample: HandArm, start_ns: int, lease: int) -> HandArm:
    """The sample by the remote site's clock."""
    capture_ns = start_ns + sample.capture_ns
    assert sample.clock is not None
    clock = replace(sample.clock, measured_ns=capture_ns)
    return replace(sample, capture_ns=capture_ns, lease=lease, clock=clock)


def _record(run: Run, loop: RemoteLoop, elapsed_ns: int) -> None:
    state = loop.snapshot.state
    if not run.states:
        if elapsed_ns < 3 * NS_PER_S:
            return
        if state is not SessionState.ENGAGED:
            loop.ask(EngagementAction.ENGAGE)
            return
        run.begun_ns = elapsed_ns
    run.states.append(state)
    run.limits_ms.append(loop.snapshot.age_limit_ms)
    run.tools.append(tuple(loop.model.forward(loop.sent.q)[:3, 3].tolist()))

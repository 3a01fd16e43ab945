"""Figures by the states of a run: following, holds, the hand's lag, the error without it; pure."""

from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.robot import FOLLOWING, Engagement, RobotState, SessionState

SECONDS_PER_MINUTE = 60.0
LAGS_MS = np.arange(0.0, 1001.0, 5.0)
GRID_NS = 5 * NS_PER_MS
BEFORE_NS = 2 * NS_PER_S
LEAST_STATES = 50  # of a second, for an error that means something

Figures = dict[str, Any]
Hand = Callable[[int], Array]


@dataclass(frozen=True, slots=True)
class Copying:
    """The tool's motion by the hand's: scale, and the rotation from the operator's frame to the base."""

    scale: float
    base_R_operator: Array

    @property
    def matrix(self) -> Array:
        """From the hand's motion to the tool's, as rows: motion @ matrix."""
        return self.scale * self.base_R_operator.T


def session_figures(states: Sequence[RobotState]) -> Figures:
    """From the first state that follows to the last: fraction followed, holds, latches, changes, and the reason.

    The fraction counts nothing after a latch as followed. `changes_in_a_second` is the most changes between engaged and
    holding within any second, `held_for` the codes for which the arm held, with their numbers, `age_limit_ms` the
    greatest age limit. Where nothing engaged, the fraction is 0 and `why` is the sentence of the readiness.
    """
    first = next((k for k, state in enumerate(states) if state.state is SessionState.ENGAGED), None)
    if first is None:
        return {"followed": 0.0, "why": states[-1].readiness.reason if states else "no state came"}
    run = states[first:]
    steps = list(pairwise(run))
    followed_ns = sum(b.t_ns - a.t_ns for a, b in steps if a.state is SessionState.ENGAGED)
    run_ns = max(1, run[-1].t_ns - run[0].t_ns)
    into = [(a.state, b.state) for a, b in steps]
    held_for = Counter(b.code for a, b in steps if (a.state, b.state) == (SessionState.ENGAGED, SessionState.HOLDING))
    changes_ns = [b.t_ns for a, b in steps if a.state is not b.state and a.state in FOLLOWING and b.state in FOLLOWING]
    is_left = run[-1].state not in FOLLOWING
    return {
        "followed": followed_ns / run_ns,
        "holds_a_minute": held_for.total() * SECONDS_PER_MINUTE * NS_PER_S / run_ns,
        "latches": sum(a in FOLLOWING and b not in FOLLOWING for a, b in into),
        "changes_in_a_second": most_within(changes_ns, NS_PER_S),
        "held_for": ", ".join(f"{code} {count}" for code, count in held_for.most_common()),
        "age_limit_ms": max(state.age_limit_ms for state in run),
        "why": run[-1].reason if is_left else "",
    }


def most_within(times_ns: Sequence[int], span_ns: int) -> int:
    """The most of the sorted times that lie within any span."""
    return max((bisect_right(times_ns, t + span_ns) - k for k, t in enumerate(times_ns)), default=0)


def following_figures(states: Sequence[RobotState], from_ns: int, hand: Hand, copying: Copying) -> Figures:
    """The hand's lag, and how far the tool is from where the hand has asked for it once that lag is taken out.

    The lag (ms) is that at which the engaged states since `from_ns` fit the true hand best, by the origin that was in
    force; so it contains the link's delay. The error (rms, mm) at that lag is by the first origin of all: what later
    ones have lost counts. `hand` is the wrist (m, operator frame) at a time. None where too little was followed.
    """
    first = next((s.engagement for s in states if s.state is SessionState.ENGAGED), None)
    engaged = [s for s in states if s.state is SessionState.ENGAGED and s.t_ns >= from_ns]
    if first is None or len(engaged) < LEAST_STATES:
        return {"lag_ms": None, "error_mm": None}
    times = np.array([s.t_ns for s in engaged], dtype=np.int64)
    tool = np.array([s.base_T_tool.position for s in engaged])
    grid = np.arange(times[0] - round(LAGS_MS[-1] * NS_PER_MS) - GRID_NS, times[-1] + GRID_NS, GRID_NS)
    asked = np.array([hand(int(t)) for t in grid]) @ copying.matrix

    def offset(origin: Engagement) -> Array:
        return np.array(origin.base_T_tool.position) - hand(origin.hand_capture_ns) @ copying.matrix

    def error_mm(lag_ms: float, offsets: Array) -> float:
        then = times - round(lag_ms * NS_PER_MS)
        wanted = offsets + np.column_stack([np.interp(then, grid, asked[:, k]) for k in range(3)])
        return 1e3 * float(np.sqrt(np.mean(np.sum((tool - wanted) ** 2, axis=1))))

    in_force = np.array([offset(s.engagement or first) for s in engaged])
    lag_ms = float(min(LAGS_MS, key=lambda lag: error_mm(float(lag), in_force)))
    return {"lag_ms": lag_ms, "error_mm": error_mm(lag_ms, offset(first))}


def hand_age_figures(states: Sequence[RobotState], from_ns: int) -> Figures:
    """From exposure to the first command, of the samples obeyed since a time: p50 and p99, ms; None without any."""
    ages = {
        s.obeyed.seq: (s.obeyed.command_ns - s.obeyed.capture_ns) / NS_PER_MS
        for s in states
        if s.obeyed is not None and s.obeyed.capture_ns > from_ns
    }
    return {f"hand_p{p}_ms": float(np.percentile(list(ages.values()), p)) if ages else None for p in (50, 99)}


def machine_figures(states: Sequence[RobotState]) -> Figures:
    """Compute the fraction of control ticks that were missed: the machine must be quick enough for the run to count."""
    if len(states) < 2:
        return {"ticks_missed": None}
    first, last = states[0].timing, states[-1].timing
    return {"ticks_missed": (last.missed - first.missed) / max(1, last.ticks - first.ticks)}


@dataclass(frozen=True, slots=True)
class Span:
    """The time when a link changed, and when it was as before again (the same for a lasting change), ns."""

    changed_ns: int
    healed_ns: int


def change_figures(states: Sequence[RobotState], span: Span) -> Figures:
    """Compute what the arm did when the link changed, from the change to the last state.

    `followed_before` is whether it followed until then, with what `age_limit_before_ms`; `held` and `latched` whether
    it did that since, also after healing: a hold begins once samples are older than that limit. `followed_after_s` is
    when it followed for good, after healing, None when it did not; `ready_after_s` when it could be engaged.
    `moved_mrad` is the most that any joint was commanded away from where it was at healing, `tool_mm_s` the tool's
    greatest speed since the change, `tool_before_mm_s` that of two seconds before it.
    """
    before = [s for s in states if s.t_ns < span.changed_ns]
    since = [s for s in states if s.t_ns >= span.changed_ns]
    after = [s for s in since if s.t_ns >= span.healed_ns]
    elsewhere = [s for s in after if s.state is not SessionState.ENGAGED]
    followed_ns = elsewhere[-1].t_ns if elsewhere else span.healed_ns
    follows = bool(after) and after[-1].state is SessionState.ENGAGED
    into = [(a.state, b.state) for a, b in pairwise(since)]
    return {
        "followed_before": bool(before) and before[-1].state in FOLLOWING,
        "age_limit_before_ms": before[-1].age_limit_ms if before else None,
        "held": any(s.state is SessionState.HOLDING for s in since),
        "latched": any(s.state not in FOLLOWING for s in since),
        "holds": into.count((SessionState.ENGAGED, SessionState.HOLDING)),
        "followed_after_s": (followed_ns - span.healed_ns) / NS_PER_S if follows else None,
        "ready_after_s": ready_after_s(after, span.healed_ns),
        "moved_mrad": _moved_mrad(after),
        "tool_mm_s": _fastest_mm_s(since),
        "tool_before_mm_s": _fastest_mm_s([s for s in states if 0 < span.changed_ns - s.t_ns < BEFORE_NS]),
        "why": "" if follows or not after else after[-1].readiness.reason,
    }


def ready_after_s(states: Sequence[RobotState], since_ns: int) -> float | None:
    """Find how long after a time the arm could first be engaged, or followed; None when it never could."""
    return next(((s.t_ns - since_ns) / NS_PER_S for s in states if s.readiness.ready), None)


def _moved_mrad(states: Sequence[RobotState]) -> float:
    q = np.array([s.q_commanded for s in states])
    return 1e3 * float(np.abs(q - q[0]).max()) if len(q) else 0.0


def _fastest_mm_s(states: Sequence[RobotState]) -> float:
    tool = np.array([s.base_T_tool.position for s in states]).reshape(-1, 3)
    seconds = np.diff([s.t_ns for s in states]) / NS_PER_S
    steps = np.linalg.norm(np.diff(tool, axis=0), axis=1)
    return 1e3 * float(np.max(steps[seconds > 0] / seconds[seconds > 0], initial=0.0))

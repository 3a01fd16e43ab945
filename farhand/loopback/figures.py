"""The figures of a loopback run, computed from what was recorded; pure."""

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S
from common.geometry import Array
from common.messages.hand import HandArm, TrackingStatus
from common.messages.robot import RobotState, SessionState
from farhand.loopback.recorder import CameraRecord, Record
from remote_site.reasons import Code

POINTS = ("elbow", "wrist", "index", "thumb", "palm")
LAGS_MS = np.arange(0.0, 2001.0, 2.0)  # the mean of nine frames at 5 a second is 0.8 s late
STAGES = ("command", "motion", "encoder", "picture", "viewer")
TRUTH_STEP_NS = 2 * NS_PER_MS
LATELY_NS = 5 * NS_PER_S

Truth = Callable[[int], Mapping[str, Array]]
Figures = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Expectation:
    """The expected motion of the tool with a point of the hand: its scale, and the rotation of the operator's frame."""

    scale: float
    base_R_operator: Array
    point: str = "wrist"


def percentiles(values: Sequence[float], *levels: int) -> Figures:
    """The percentiles of values by name (p50 ...), None where there are no values."""
    return {f"p{level}": _rounded(np.percentile(values, level)) if values else None for level in levels}


def latency_figures(states: Sequence[RobotState], hands: Sequence[HandArm] = ()) -> Figures:
    """Exposure to joint command, and exposure to the robot's motion, over all obeyed samples, ms.

    From the samples in `hands` also the reading of their pictures to the command: without their drawing, where they are
    simulated. The clocks of both sites are one here.
    """
    read = {(hand.session, hand.seq): hand.read_ns for hand in hands if hand.read_ns is not None}
    last = {(s.obeyed.session, s.obeyed.seq): s.obeyed for s in states if s.obeyed is not None}
    command = [(o.command_ns - o.capture_ns) / NS_PER_MS for o in last.values()]
    since_read = [(o.command_ns - read[key]) / NS_PER_MS for key, o in last.items() if key in read]
    motion = [(o.motion_ns - o.capture_ns) / NS_PER_MS for o in last.values() if o.motion_ns is not None]
    return {
        "capture_to_command_ms": percentiles(command, 50, 95, 99),
        "capture_to_motion_ms": percentiles(motion, 50, 95, 99),
        "picture_to_command_ms": percentiles(since_read, 50, 95, 99),
    }


def trace_figures(states: Sequence[RobotState], cameras: Mapping[str, CameraRecord]) -> Figures:
    """The stages of each traced sample in ms after its exposure, and the percentiles of every stage.

    The last stages are the exposure of the first picture, of any camera, that was taken once the encoders had shown the
    sample, and its arrival at the viewer. The clocks of both sites are one here.
    """
    pictures = sorted(
        pair
        for camera in cameras.values()
        for pair in zip(camera.exposures_ns, camera.arrivals_ns, strict=False)  # more may come meanwhile
    )
    exposures = [exposed_ns for exposed_ns, _ in pictures]
    samples = []
    for traced in {(s.traced.session, s.traced.seq): s.traced for s in states if s.traced is not None}.values():
        next_picture = bisect_left(exposures, traced.encoder_ns)
        if next_picture == len(pictures):
            break
        stages = (traced.command_ns, traced.motion_ns, traced.encoder_ns, *pictures[next_picture])
        after = [_rounded((t_ns - traced.capture_ns) / NS_PER_MS) for t_ns in stages]
        samples.append({"seq": traced.seq, **dict(zip(STAGES, after, strict=True))})
    levels = {stage: percentiles([sample[stage] for sample in samples], 50, 95) for stage in STAGES}
    return {"trace_ms": levels, "traces": samples}


def tracking_figures(hands: Sequence[HandArm], truth: Truth) -> Figures:
    """Rate, number of lost frames after initialisation, and error per point against the ground truth, mm."""
    tracked = [h for h in hands if h.status is not TrackingStatus.INITIALISING]
    lost = sum(h.wrist is None or h.status is TrackingStatus.LOST for h in tracked)
    errors: dict[str, list[float]] = {name: [] for name in POINTS}
    for hand in tracked:
        true = truth(hand.capture_ns)
        for name in POINTS:
            point = getattr(hand, name)
            if point is not None:
                errors[name].append(1e3 * float(np.linalg.norm(np.array(point) - true[name])))
    return {
        "fps": _rounded(per_second([h.capture_ns for h in hands])),
        "frames": len(tracked),
        "lost": lost,
        "thumb_absent": sum(h.thumb is None for h in tracked),
        "error_mm": {name: _mean_max(values) for name, values in errors.items()},
    }


def follow_figures(states: Sequence[RobotState], truth: Truth, expectation: Expectation) -> Figures:
    """The measured tool's distance from where the true hand commands it, at the lag that fits best: mean, p95, mm."""
    followed = [s for s in states if s.state is SessionState.ENGAGED and s.engagement is not None]
    if not followed:
        return {"follow_mm": {"mean": None, "p95": None}, "follow_lag_ms": None}
    times = np.array([s.t_ns for s in followed], dtype=float)
    tool = np.array([s.base_T_tool.position for s in followed])
    end_ns = int(times[-1]) + TRUTH_STEP_NS
    grid = np.arange(int(times[0]) - round(LAGS_MS[-1] * NS_PER_MS), end_ns, TRUTH_STEP_NS, dtype=np.int64)
    positions = np.array([truth(int(t))[expectation.point] for t in grid])
    origin_times = np.array([s.engagement.hand_capture_ns for s in followed if s.engagement], dtype=float)
    origins = np.array([s.engagement.base_T_tool.position for s in followed if s.engagement])
    hand_origin = np.array([truth(int(t))[expectation.point] for t in origin_times])

    def errors_at(lag_ms: float) -> Array:
        then = times - lag_ms * NS_PER_MS
        hand = np.column_stack([np.interp(then, grid, positions[:, k]) for k in range(3)])
        expected = origins + expectation.scale * (hand - hand_origin) @ expectation.base_R_operator.T
        distance: Array = 1e3 * np.linalg.norm(tool - expected, axis=1)
        return distance

    best = min(LAGS_MS, key=lambda lag: float(errors_at(lag).mean()))
    errors = errors_at(float(best))
    return {
        "follow_mm": {"mean": _rounded(errors.mean()), "p95": _rounded(np.percentile(errors, 95))},
        "follow_lag_ms": float(best),
    }


def video_figures(cameras: Mapping[str, CameraRecord]) -> Figures:
    """Rate and exposure to decoded picture of every camera."""
    return {
        name: {
            "fps": _rounded(per_second(camera.arrivals_ns)),
            "glass_to_glass_ms": percentiles(camera.glass_to_glass_ms, 50, 95),
            "not_live": camera.not_live,
        }
        for name, camera in cameras.items()
    }


def control_figures(states: Sequence[RobotState]) -> Figures:
    """The control loop's rate and lateness, as it measured them itself; None without any state."""
    if not states:
        return {"hz": None, "late_p99_us": None, "missed": None, "missed_share": None, "real_time": None}
    timing = states[-1].timing
    return {
        "hz": _rounded(timing.hz),
        "late_p99_us": _rounded(timing.late_p99_us),
        "missed": timing.missed,
        "missed_share": round(timing.missed / max(1, timing.ticks), 5),
        "real_time": timing.real_time,
    }


def all_figures(record: Record, truth: Truth, expectation: Expectation) -> Figures:
    """Every figure of the report that the record holds."""
    states = list(record.states)
    follows = [state.state is SessionState.ENGAGED for state in states]
    return {
        **latency_figures(states, record.hands),
        **trace_figures(states, record.cameras),
        "tracking": tracking_figures(list(record.hands), truth),
        **follow_figures(states, truth, expectation),
        "video": video_figures(record.cameras),
        "control": control_figures(states),
        "engagements": states[-1].engagement.number if states and states[-1].engagement else 0,
        "holds": sum(before and not after for before, after in pairwise(follows)),
        "followed_share": followed_share(states),
    }


def followed_share(states: Sequence[RobotState]) -> float:
    """The part of the states since the first engagement in which the arm followed; 0 without one."""
    since_first = [state.state is SessionState.ENGAGED for state in states if state.engagement is not None]
    return _rounded(np.mean(since_first)) if since_first else 0.0


def per_second(times_ns: Sequence[int]) -> float:
    """Compute how often a second something came at these times, 0 unless it came twice."""
    if len(times_ns) < 2:
        return 0.0
    return (len(times_ns) - 1) * NS_PER_S / max(1, times_ns[-1] - times_ns[0])


def session_events(states: Sequence[RobotState]) -> list[str]:
    """Each change of the session after the first engagement: seconds since then, the new state, and its reason."""
    begin = next((k for k, s in enumerate(states) if s.state is SessionState.ENGAGED), len(states))
    return [
        f"{(now.t_ns - states[begin].t_ns) / NS_PER_S:.1f} s: {now.state.value}, {now.reason}"
        for before, now in pairwise(states[begin:])
        if now.state is not before.state
    ]


def troubles(states: Sequence[RobotState]) -> list[str]:
    """Say what kept the arm from following most of the last seconds, and what is wrong with the hand's link.

    A state's own reason may be that of a moment: between two late samples it only counts good ones.
    """
    lately = [state for state in states if states[-1].t_ns - state.t_ns < LATELY_NS]
    answers = [state.readiness for state in lately if not state.readiness.ready]
    lacking = {answer.code: answer.reason for answer in answers if answer.code != Code.COLLECTING}
    codes = Counter(answer.code for answer in answers if answer.code in lacking)
    usual = [lacking[code] for code, _ in codes.most_common(1)] or [state.reason for state in states[-1:]]
    links = [state.hand_link.reason for state in lately if state.hand_link is not None and state.hand_link.reason]
    return [*usual, *links[-1:]]


def _mean_max(values: Sequence[float]) -> Figures:
    return {
        "mean": _rounded(np.mean(values)) if values else None,
        "max": _rounded(np.max(values)) if values else None,
    }


def _rounded(value: float | np.floating[Any]) -> float:
    return round(float(value), 3)

"""Latency of each stage over the last minute: newest value, median and 95th percentile."""

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate
from common.messages.robot import RobotState, Traced

MINUTE_NS = 60 * NS_PER_S
MOST = 4096
SUMMARY_NS = 250 * NS_PER_MS
TRACE_NS = NS_PER_S  # a sample is traced no longer


@dataclass
class Window:
    """The values of one stage in ms, with the times (ns) at which they were added."""

    _values: deque[tuple[int, float]] = field(default_factory=lambda: deque(maxlen=MOST))

    def add(self, now_ns: int, value_ms: float) -> None:
        """Take a value."""
        self._values.append((now_ns, value_ms))

    def summary(self, now_ns: int) -> dict[str, float | int | None]:
        """Newest value of the last second, p50 and p95 of the last minute, and how many there were."""
        while self._values and now_ns - self._values[0][0] > MINUTE_NS:
            self._values.popleft()
        values = [value for _, value in self._values]
        p50, p95 = np.percentile(values, (50, 95)).tolist() if values else (None, None)
        fresh = self._values and now_ns - self._values[-1][0] < NS_PER_S
        return {
            "newest": self._values[-1][1] if fresh else None,
            "p50": p50,
            "p95": p95,
            "count": len(values),
        }


@dataclass(frozen=True, slots=True)
class Trace:
    """The times of one sample's stages, in ms after its exposure.

    Its command was written, reached the robot, was shown by the encoders; then a picture was taken, and painted.
    """

    seq: int
    command_ms: float
    motion_ms: float
    encoder_ms: float
    exposed_ms: float
    shown_ms: float


class Latencies:
    """Computes from states what the command and the motion took, and from the page what the pictures took."""

    NAMES = ("command", "motion", "encoder", "picture", "round_trip", "uncertainty", "hand_to_eye")

    def __init__(self) -> None:
        self.windows = {name: Window() for name in self.NAMES}
        self.trace: Trace | None = None
        self._painted: dict[str, int] = {}
        self._summary: dict[str, dict[str, float | int | None]] = {}
        self._summed_ns = 0
        self._commanded = self._moved = self._measured = (0, -1)
        self._unseen: tuple[Traced, int] | None = None  # the sample not seen yet, and its exposure by the remote clock

    def add_state(self, state: RobotState, now_ns: int) -> None:
        """Take a state; each obeyed sample counts once, and only where the clocks' offset is known."""
        obeyed, clock = state.obeyed, state.clock
        if obeyed is None or clock is None:
            return
        sample = (obeyed.session, obeyed.seq)
        exposed_ns = obeyed.capture_ns + clock.remote_minus_local_ns
        command_ms = (obeyed.command_ns - exposed_ns) / NS_PER_MS
        if _is_newer(sample, self._commanded):
            self._commanded = sample
            self.windows["command"].add(now_ns, command_ms)
        if obeyed.motion_ns is not None and _is_newer(sample, self._moved):
            self._moved = sample
            motion_ms = (obeyed.motion_ns - obeyed.command_ns) / NS_PER_MS
            self.windows["motion"].add(now_ns, motion_ms)
        if state.traced is not None:
            self._trace(state.traced, clock.remote_minus_local_ns, now_ns)

    def _trace(self, traced: Traced, remote_minus_local_ns: int, now_ns: int) -> None:
        sample = (traced.session, traced.seq)
        if sample == self._measured:
            return
        self._measured = sample
        self.windows["encoder"].add(now_ns, (traced.encoder_ns - traced.command_ns) / NS_PER_MS)
        old = now_ns + remote_minus_local_ns - traced.encoder_ns > TRACE_NS  # repeated to a new console
        if self._unseen is None and not old:
            self._unseen = (traced, traced.capture_ns + remote_minus_local_ns)

    def add_clock(self, known: ClockEstimate | None, round_trip_ms: float | None, now_ns: int) -> None:
        """Take how well the remote clock is known, and how long its last question took."""
        if known is not None:
            self.windows["uncertainty"].add(now_ns, known.offset.uncertainty_ns / NS_PER_MS)
        if round_trip_ms is not None:
            self.windows["round_trip"].add(now_ns, round_trip_ms)

    def summary(self, now_ns: int) -> dict[str, dict[str, float | int | None]]:
        """Every stage's summary, computed four times a second at most."""
        if now_ns - self._summed_ns > SUMMARY_NS:
            self._summed_ns = now_ns
            self._summary = {name: window.summary(now_ns) for name, window in self.windows.items()}
        return self._summary

    def painted(self, camera: str, capture_ns: int, age_ms: float, now_ns: int) -> None:
        """A picture taken at `capture_ns` (by the remote clock) was painted at this age; repetitions do not count."""
        if self._painted.get(camera) == capture_ns:
            return
        self._painted[camera] = capture_ns
        self.windows["picture"].add(now_ns, age_ms)
        if self._unseen is None or capture_ns < self._unseen[0].encoder_ns:
            return
        (traced, hand_ns), self._unseen = self._unseen, None
        if capture_ns - traced.encoder_ns > TRACE_NS:  # no page was open meanwhile
            return
        stages = (traced.command_ns, traced.motion_ns, traced.encoder_ns, capture_ns, capture_ns + age_ms * NS_PER_MS)
        self.trace = Trace(traced.seq, *((t_ns - hand_ns) / NS_PER_MS for t_ns in stages))
        self.windows["hand_to_eye"].add(now_ns, self.trace.shown_ms)


def _is_newer(sample: tuple[int, int], last: tuple[int, int]) -> bool:
    """Return whether a sample, by session and number, has not been counted: a slow robot's states alternate."""
    return sample[0] != last[0] or sample[1] > last[1]

"""Summary of a run in three sentences: how long, engaged, held and why, stopped, and the worst of it; pure."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

from common.clock import NS_PER_S
from common.messages.robot import FOLLOWING, STOPPED, RobotState, SessionState

LONGEST_GAP_NS = NS_PER_S  # without a state for longer nothing is known of what lies between
MOST_CODES = 32
SHOWN_CODES = 3
OTHER = "other"


@dataclass(slots=True)
class Worst:
    """The largest of what was measured while the arm was engaged; None before anything was."""

    hand_age_ms: float | None = None
    late_p99_us: float | None = None

    def note(self, state: RobotState) -> None:
        """Take the figures of a state."""
        if state.hand_link is not None and state.hand_link.age_ms is not None:
            self.hand_age_ms = max(self.hand_age_ms or 0.0, state.hand_link.age_ms)
        self.late_p99_us = max(self.late_p99_us or 0.0, state.timing.late_p99_us)


@dataclass
class RunSummary:
    """Counts over one run, fed with each state as it is published or heard; its memory is bounded.

    The times between two states count as the former's, up to a second.
    """

    engagements: int = 0
    engaged_ns: int = 0
    holds: Counter[str] = field(default_factory=Counter)
    held_ns: int = 0
    stops: int = 0
    faults: int = 0
    worst: Worst = field(default_factory=Worst)
    _missed: int = 0
    _ticks: int = 0
    _begun_ns: int | None = None
    _last_ns: int = 0
    _state: SessionState | None = None
    _code: str = ""

    def note(self, state: RobotState | None, now_ns: int) -> None:
        """Take what is known now; None where it is not known, or not this site's own engagement."""
        self._pass_time(now_ns)
        before, self._state = self._state, state.state if state is not None else None
        if state is None:
            return
        self._missed, self._ticks = state.timing.missed, state.timing.ticks
        self.engagements += self._state in FOLLOWING and before not in FOLLOWING
        self.stops += state.code == STOPPED and self._code != STOPPED
        self._code = state.code
        if self._state is not before:
            self.faults += self._state is SessionState.FAULT
            if self._state is SessionState.HOLDING:
                self._hold(state.code)
        if self._state in FOLLOWING:
            self.worst.note(state)

    def sentences(self) -> dict[str, str]:
        """Return the sentences to say at the end, each by its name; what there is nothing to say of is left out."""
        return dict(self._sentences())

    def _sentences(self) -> Iterator[tuple[str, str]]:
        ran_ns = self._last_ns - self._begun_ns if self._begun_ns is not None else 0
        engaged = f"engaged {_times(self.engagements)} for {in_words(self.engaged_ns)}"
        yield "run", f"{in_words(ran_ns)}, {engaged if self.engagements else 'never engaged'}"
        count = self.holds.total()
        if self.engagements or self.stops or self.faults:
            held = f"{_times(count)} for {in_words(self.held_ns)} ({self._why()})" if count else "never"
            yield "held", f"{held}; stops: {self.stops}, faults: {self.faults}"
        if self.worst.late_p99_us is not None:
            age = "" if self.worst.hand_age_ms is None else f"hand age {self.worst.hand_age_ms:.0f} ms, "
            late = f"control {self.worst.late_p99_us / 1000:.1f} ms late (p99)"
            yield "worst", f"{age}{late}, {self._missed} of {self._ticks} ticks missed"

    def _pass_time(self, now_ns: int) -> None:
        if self._begun_ns is None:
            self._begun_ns = self._last_ns = now_ns
        passed_ns, self._last_ns = now_ns - self._last_ns, now_ns
        if self._state in FOLLOWING and passed_ns <= LONGEST_GAP_NS:
            self.engaged_ns += passed_ns
            self.held_ns += passed_ns if self._state is SessionState.HOLDING else 0

    def _hold(self, code: str) -> None:
        self.holds[code if code in self.holds or len(self.holds) < MOST_CODES else OTHER] += 1

    def _why(self) -> str:
        named = [f"{count} {code}" for code, count in self.holds.most_common(SHOWN_CODES)]
        rest = self.holds.total() - sum(count for _, count in self.holds.most_common(SHOWN_CODES))
        return ", ".join([*named, f"{rest} others"] if rest else named)


def in_words(duration_ns: int) -> str:
    """A duration as people say it: 41.2 s, 12 min 4 s, 3 h 5 min."""
    seconds = duration_ns / NS_PER_S
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, left_s = divmod(round(seconds), 60)
    return f"{minutes} min {left_s} s" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"


def _times(count: int) -> str:
    return {0: "never", 1: "once"}.get(count, f"{count} times")

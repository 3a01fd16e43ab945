"""Episodes within a recording: what begins and ends them, their task and how it went; pure."""

from dataclasses import dataclass, field
from enum import StrEnum

import msgspec

from common.messages.base import Count, Difference, Text
from common.messages.recording import EpisodeOutcome
from common.messages.requests import RecordAction
from common.recording.config import EpisodeBounds

MOST_EPISODES = 10_000  # of a recording: its readers take no more


class EpisodeEventKind(StrEnum):
    """What an event says of its episode."""

    BEGIN = "begin"
    END = "end"
    LABEL = "label"


class EpisodeEvent(msgspec.Struct, frozen=True, kw_only=True):
    """A change of an episode, with all that is known of it then; of several events of one episode the last holds.

    `t_ns` is by the clock of the host that records; `by` is who or what caused it: an operator, "engagement", or
    "recording" where that began or ended.
    """

    event: EpisodeEventKind
    episode: Count
    t_ns: Difference
    by: str
    task: Text
    outcome: EpisodeOutcome
    note: str


@dataclass
class Episodes:
    """Numbers the episodes of one recording from 1; of an ended one, outcome and note may still be given.

    After MOST_EPISODES none begins any more: what would begin one has no effect.
    """

    bounds: EpisodeBounds
    task: str = ""
    number: int = 0
    is_open: bool = False
    outcome: EpisodeOutcome = EpisodeOutcome.UNKNOWN
    note: str = ""
    _task: str = field(default="", init=False)
    _engaged: bool = field(default=False, init=False)
    _begun_ns: int = field(default=0, init=False)
    _ended_ns: int = field(default=0, init=False)

    @property
    def shown_task(self) -> str:
        """The task of the episode under way, else that of the next."""
        return self._task if self.is_open else self.task

    def lasted_ns(self, now_ns: int) -> int:
        """Return how long the episode under way has lasted by now, or the last one did, ns; 0 before the first."""
        return max(0, (now_ns if self.is_open else self._ended_ns) - self._begun_ns)

    def follow(self, *, engaged: bool, t_ns: int) -> list[EpisodeEvent]:
        """Note whether the arm is engaged now, a short hold included; return the events that follow from it."""
        changed, self._engaged = engaged is not self._engaged, engaged
        if not changed or self.bounds is not EpisodeBounds.ENGAGEMENT:
            return []
        if engaged and not self.is_open:
            return self._begin(t_ns, "engagement")
        return self._end(t_ns, "engagement") if not engaged else []

    def act(
        self, action: RecordAction, by: str, t_ns: int, task: str, outcome: EpisodeOutcome, note: str
    ) -> list[EpisodeEvent]:
        """Do what an operator asks for; return its events, none without effect."""
        self.task = task or self.task
        if action is RecordAction.BEGIN:
            return self._begin(t_ns, by)
        if self.number == 0:
            return []
        said = self.outcome, self.note, self._task
        self._task = task or self._task
        self.outcome = outcome if outcome is not EpisodeOutcome.UNKNOWN else self.outcome
        self.note = note or self.note
        if action is RecordAction.END and self.is_open:
            return self._end(t_ns, by)
        changed = said != (self.outcome, self.note, self._task)
        return [self._event(EpisodeEventKind.LABEL, t_ns, by)] if changed else []

    def finish(self, t_ns: int) -> list[EpisodeEvent]:
        """The recording ends, and with it the episode under way."""
        return self._end(t_ns, "recording")

    def _begin(self, t_ns: int, by: str) -> list[EpisodeEvent]:
        """The next episode, which ends the one under way."""
        if self.number >= MOST_EPISODES:
            return []
        ended = self._end(t_ns, by)
        self.number, self._begun_ns = self.number + 1, t_ns
        self.is_open, self.outcome, self.note, self._task = True, EpisodeOutcome.UNKNOWN, "", self.task
        return [*ended, self._event(EpisodeEventKind.BEGIN, t_ns, by)]

    def _end(self, t_ns: int, by: str) -> list[EpisodeEvent]:
        if not self.is_open:
            return []
        self.is_open, self._ended_ns = False, t_ns
        return [self._event(EpisodeEventKind.END, t_ns, by)]

    def _event(self, kind: EpisodeEventKind, t_ns: int, by: str) -> EpisodeEvent:
        return EpisodeEvent(
            event=kind,
            episode=self.number,
            t_ns=t_ns,
            by=by,
            task=self._task,
            outcome=self.outcome,
            note=self.note,
        )

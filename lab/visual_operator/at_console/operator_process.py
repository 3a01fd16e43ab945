"""The operator's process: what it is given, and what it notes of its work."""

import msgspec

from common.clock import NS_PER_S
from lab.visual_operator.operator import Notes


class OperatorSetup(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Everything that the operator's process is given: the console's port, and the socket of its hand's cameras.

    It looks every `page_ns`, gives up after `most_s`, waits `patience_s` for a page that has everything, and leaves
    its notes in a file.
    """

    port: int
    led_by: str
    notes: str
    roll_fixed: bool
    seed: int
    page_ns: int
    most_s: float
    patience_s: float = 60.0


class TrialNotes(msgspec.Struct, kw_only=True, forbid_unknown_fields=True):
    """The operator's notes: when it began and ended (ns), counts; of each look how old the oldest view was and how
    long it took (ms); how often the page gave which reason of the session's state.

    `late` is how often its hand stood still because its process came late.
    """

    start_ns: int
    end_ns: int = 0
    clutches: int = 0
    misses: int = 0
    gave_up: bool = False
    late: int = 0
    ages_ms: list[float] = []
    looks_ms: list[float] = []
    reasons: dict[str, int] = {}

    @property
    def time_s(self) -> float:
        """The time that the trial lasted, s."""
        return (self.end_ns - self.start_ns) / NS_PER_S

    def add_look(self, age_ms: float, took_ms: float, code: str) -> None:
        """Note a look, and the code of the state's reason."""
        self.reasons[code] = self.reasons.get(code, 0) + 1
        self.ages_ms.append(age_ms)
        self.looks_ms.append(took_ms)

    def end(self, notes: Notes, end_ns: int, late: int) -> "TrialNotes":
        """Note how it ended."""
        self.end_ns, self.late = end_ns, late
        self.clutches, self.misses, self.gave_up = notes.clutches, notes.misses, notes.gave_up
        return self

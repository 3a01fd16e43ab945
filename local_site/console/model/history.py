"""Events as sentences with their times, newest first."""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_S
from common.messages.robot import RobotState

KEPT = 30
QUIET_NS = NS_PER_S  # at most one change of the code a second: while engaged it may change at every tick


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened: its number, its time by the console's clock in ns, its kind, and what it was."""

    number: int
    t_ns: int
    kind: str
    text: str


class History:
    """Keeps the last events; a repetition is not noted."""

    def __init__(self) -> None:
        self.events: deque[Event] = deque(maxlen=KEPT)
        self._count = 0
        self._last: dict[str, str] = {}
        self._noted_ns = 0

    def note(self, kind: str, text: str, now_ns: int) -> None:
        """Note an event."""
        self._count += 1
        self.events.appendleft(Event(self._count, now_ns, kind, text))

    def note_change(self, topic: str, kind: str, text: str, now_ns: int) -> None:
        """Note the state of a topic, if it has changed."""
        if self._last.get(topic) != text:
            self._last[topic] = text
            self.note(kind, text, now_ns)

    def add_state(self, state: RobotState, now_ns: int) -> None:
        """Note a change of state, of its code, or of who holds the lease."""
        self._note_session(state, now_ns)
        holder = f"{state.lease.holder} holds the lease" if state.lease is not None else "nobody holds the lease"
        self.note_change("lease", "lease", holder, now_ns)
        if state.lease is not None and state.lease.asked_by is not None:
            self.note_change("asked", "lease", f"{state.lease.asked_by} asks for the lease", now_ns)

    def _note_session(self, state: RobotState, now_ns: int) -> None:
        same_state = self._last.get("state") == state.state.value
        if same_state and (self._last.get("code") == state.code or now_ns - self._noted_ns < QUIET_NS):
            return
        self._last |= {"state": state.state.value, "code": state.code}
        self._noted_ns = now_ns
        word = state.state.value
        self.note(word, state.reason if state.reason.startswith(word) else f"{word}: {state.reason}", now_ns)

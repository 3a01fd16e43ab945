"""To which events of a recording a person may want to jump: changes of the session's state, stops, episodes; pure."""

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from common.messages.robot import STOPPED, SessionState

SESSION_LINE = re.compile(r"(?P<state>\w+) \((?P<code>\w+)\): (?P<sentence>.*)", re.DOTALL)
SESSION = "session"
STOP = "stop"


@dataclass(frozen=True, slots=True)
class RecordedEvent:
    """A point of the recording to which a person may want to jump: seconds from its beginning, its kind, and words."""

    at_s: float
    kind: str
    words: str


def worth_a_jump(events: Iterable[RecordedEvent]) -> Iterator[RecordedEvent]:
    """Of the session's lines those with another state than before, or a stop; all other events as they are.

    What a site says while it starts, and limits that come and go during an engagement, change no state.
    """
    state, is_stopped = SessionState.DISENGAGED.value, False
    for event in events:
        said = SESSION_LINE.fullmatch(event.words) if event.kind == SESSION else None
        if said is None:
            yield event
            continue
        stops = said["code"] == STOPPED
        if said["state"] != state or (stops and not is_stopped):
            yield replace(event, kind=STOP if stops else said["state"], words=_words(said["state"], said["sentence"]))
        state, is_stopped = said["state"], stops


def _words(state: str, sentence: str) -> str:
    return sentence if sentence.startswith(state) else f"{state}: {sentence}"

"""The episodes of a recording, put together from the events that were kept of them."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec

from common.errors import RecordingError
from common.messages.recording import EpisodeOutcome
from common.recording.episodes import MOST_EPISODES, EpisodeEvent, EpisodeEventKind
from common.recording.hand_transcript import EPISODE
from common.recording.reader import KeptMessage, RecordingReader, as_recorded

MOST_EVENT_BYTES = 6 << 10  # of one event; a task and a note have at most 400 characters each


class RecordedEpisode(NamedTuple):
    """An episode from `begin_ns` to `end_ns` by the clock of the host that recorded; None where no event says when."""

    number: int
    begin_ns: int | None
    end_ns: int | None
    task: str
    outcome: EpisodeOutcome
    note: str


def read_episodes(parts: Sequence[Path]) -> list[RecordedEpisode]:
    """The episodes of a recording, from all its files in order."""
    return episodes_of(_events_in(parts))


def _events_in(parts: Sequence[Path]) -> Iterator[EpisodeEvent]:
    for part in parts:
        with RecordingReader(part) as recording, as_recorded(part):
            yield from episode_events(recording)


def episode_events(recording: RecordingReader) -> Iterator[EpisodeEvent]:
    """The events of one file, by their times."""
    return map(event_in, recording.messages([EPISODE.name]))


def event_in(message: KeptMessage) -> EpisodeEvent:
    """The event that a message of this topic is; ValueError for one that is longer than any."""
    if len(message.data) > MOST_EVENT_BYTES:
        size, most = len(message.data) >> 10, MOST_EVENT_BYTES >> 10
        raise ValueError(f"an event of {size} kB; a recorder's have at most {most}")
    return msgspec.json.decode(message.data, type=EpisodeEvent)


def episodes_of(events: Iterable[EpisodeEvent]) -> list[RecordedEpisode]:
    """The episodes in the order of their first events: of several events of one episode the last holds.

    RecordingError for more than any recording has.
    """
    found: dict[int, RecordedEpisode] = {}
    for event in events:
        known = found.get(event.episode)
        begin_ns, end_ns = (known.begin_ns, known.end_ns) if known is not None else (None, None)
        if event.event is EpisodeEventKind.BEGIN:
            begin_ns = event.t_ns
        elif event.event is EpisodeEventKind.END:
            end_ns = event.t_ns
        found[event.episode] = RecordedEpisode(event.episode, begin_ns, end_ns, event.task, event.outcome, event.note)
        if len(found) > MOST_EPISODES:
            raise RecordingError(f"a recording of more than {MOST_EPISODES} episodes: give one that a recorder wrote")
    return list(found.values())

"""Recordings as exporters read them: MCAP files of a cell, the parts of one recording joined."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import chain
from pathlib import Path

import simplejpeg
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from common.errors import RecordingError
from common.messages.base import MOST_JOINTS
from common.messages.recording import EpisodeOutcome
from common.recording.folder import NAME
from common.recording.reader import KeptMessage, RecordingReader, as_recorded
from common.recording.recorded_episodes import RecordedEpisode, episode_events, episodes_of
from common.text import name_mistake
from farhand.export.recorded_signals import SIGNAL_TOPICS, signals_of
from farhand.export.session import (
    MOST_PIXELS,
    MOST_VIEWS,
    RecordedSession,
    SessionEpisode,
    SessionFacts,
    SessionSignals,
    ViewPicture,
)
from remote_site.recording.topics import GRIPPER, image_topic
from remote_site.recording.transcript import CELL_TABLE

PART_DIGITS = len("_001")
SUCCESS = {EpisodeOutcome.SUCCESS: True, EpisodeOutcome.FAILURE: False, EpisodeOutcome.UNKNOWN: None}


@contextmanager
def open_sessions(paths: Sequence[Path]) -> Iterator[list[RecordedSession]]:
    """The sessions of these files in their order; RecordingError for a file that is no whole recording of a cell."""
    with ExitStack() as stack:
        sessions: list[RecordedSession] = []
        for whole, parts in parts_by_session(paths).items():
            readers = [stack.enter_context(RecordingReader(part)) for part in parts]
            sessions.append(McapSession(whole.name, parts, readers))
        yield sessions


def parts_by_session(paths: Sequence[Path]) -> dict[Path, list[Path]]:
    """The files of each session by its folder and name: the parts of a split recording in order, each file once."""
    found: dict[Path, set[Path]] = defaultdict(set)
    for path in paths:
        stem = path.stem
        found[path.parent / (stem[:-PART_DIGITS] if NAME.fullmatch(path.name) else stem)].add(path)
    return {whole: sorted(parts) for whole, parts in found.items()}


def within(episodes: Iterable[RecordedEpisode], begin_ns: int, end_ns: int) -> tuple[SessionEpisode, ...]:
    """The episodes by their beginnings; what is before or behind this file's messages is cut off."""
    found = [
        SessionEpisode(
            episode.number,
            begin_ns if episode.begin_ns is None else min(max(episode.begin_ns, begin_ns), end_ns),
            end_ns if episode.end_ns is None else min(max(episode.end_ns, begin_ns), end_ns),
            episode.task,
            SUCCESS[episode.outcome],
            episode.note,
        )
        for episode in episodes
    ]
    return tuple(sorted(found, key=lambda episode: episode.begin_ns))


class McapSession:
    """One recording of a cell, in one file or several."""

    def __init__(self, name: str, paths: Sequence[Path], readers: Sequence[RecordingReader]) -> None:
        self._readers = readers
        first = readers[0]
        try:
            cell = first.table(CELL_TABLE)
            robot, joints = cell["robot"], _joints(cell["joints"])
        except KeyError as error:
            cure = "leave it out, and export what 'farhand record' keeps at the remote site"
            raise RecordingError(f"{paths[0]} is no recording of a cell: {cure}") from error
        begin_ns = min(reader.span_ns[0] for reader in readers)
        end_ns = max(reader.span_ns[1] for reader in readers)
        topics = {topic for reader in readers for topic, count in reader.topics.items() if count}
        size = sum(path.stat().st_size for path in paths)
        self._views = {image_topic(view).name: view for view in _views(topics)}
        with as_recorded(paths[0]):
            episodes = episodes_of(chain.from_iterable(map(episode_events, readers)))
            sizes_px = {view: self._size_px(topic) for topic, view in self._views.items()}
        self.facts = SessionFacts(
            name=name,
            identity=f"{name} {size} {begin_ns + first.epoch_minus_clock_ns}",
            robot=robot,
            joint_names=joints,
            has_gripper=GRIPPER.name in topics,
            views=sizes_px,
            begin_ns=begin_ns,
            end_ns=end_ns,
            utc_minus_clock_ns=first.epoch_minus_clock_ns,
            episodes=within(episodes, begin_ns, end_ns),
        )

    def signals(self) -> SessionSignals:
        """All of it but its pictures."""
        with as_recorded(self._readers[0].path):
            return signals_of(self._messages(SIGNAL_TOPICS), self.facts.joint_names)

    def pictures(self, begin_ns: int, end_ns: int) -> Iterator[ViewPicture]:
        """The pictures of all views exposed in this time, in the order of their exposures."""
        with as_recorded(self._readers[0].path):
            for topic, t_ns, _, data in self._messages(list(self._views), begin_ns, end_ns):
                yield ViewPicture(self._views[topic], t_ns, CompressedImage.FromString(data).data)

    def _messages(
        self, topics: Sequence[str], begin_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[KeptMessage]:
        """Of all parts, one after the other."""
        for reader in self._readers:
            yield from reader.messages(topics, begin_ns, end_ns)

    def _size_px(self, topic: str) -> tuple[int, int]:
        """The size (width, height) of a view's pictures, from its first one."""
        kept = next(self._messages([topic]), None)
        if kept is None:
            raise ValueError(f"{topic} has no picture, though its index counts some")
        height, width, _, _ = simplejpeg.decode_jpeg_header(CompressedImage.FromString(kept.data).data)
        if width * height > MOST_PIXELS:
            raise ValueError(f"a picture of {width} x {height} pixels, more than any camera gives")
        return width, height


def _joints(words: str) -> tuple[str, ...]:
    names = tuple(words.split(","))
    if len(names) > MOST_JOINTS or len(set(names)) < len(names):
        raise RecordingError(f"{len(names)} joints: give a recording of an arm with at most {MOST_JOINTS}, each once")
    return names


def _views(topics: set[str]) -> list[str]:
    """The cameras whose pictures are kept, by name."""
    prefix = image_topic("").name
    views = sorted(topic.removeprefix(prefix) for topic in topics if topic.count("/") == 2 and topic.startswith(prefix))
    if len(views) > MOST_VIEWS:
        raise RecordingError(f"{len(views)} views: give a recording of a site, which has at most {MOST_VIEWS} cameras")
    for view in views:
        if wrong := name_mistake(view):
            raise RecordingError(f"the name of a camera {wrong}, in the site's configuration, and record again")
    return views

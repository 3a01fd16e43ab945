"""`farhand export lerobot`: sessions checked to be of one kind, their episodes encoded, the dataset put together."""

from collections.abc import Callable, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from common.clock import NS_PER_S
from common.errors import ExportError, InterruptionError
from farhand.export.lerobot.assembly import Assembly, kept
from farhand.export.lerobot.encoding import EpisodeEncoder
from farhand.export.lerobot.features import DatasetShape, shape_of
from farhand.export.lerobot.staging import ExportJob, Staging
from farhand.export.session import RecordedSession, SessionEpisode
from farhand.terminal import ShowProgress

UNNAMED = "not named"
Planned = tuple[RecordedSession, SessionEpisode]


class ExportSettings(NamedTuple):
    """What is asked for: `fps` frames per second, these views (all without any), a task for episodes without one."""

    out: Path
    fps: int = 30
    views: tuple[str, ...] = ()
    task: str = UNNAMED


class ExportSummary(NamedTuple):
    """What came of it: what was left out and why, and how many frames were encoded now."""

    episodes: int
    frames: int
    encoded: int
    left_out: tuple[str, ...]


def export_lerobot(
    sessions: Sequence[RecordedSession],
    settings: ExportSettings,
    should_stop: Callable[[], bool],
    show: ShowProgress,
) -> ExportSummary:
    """Write a dataset; ExportError for sessions that are not of one kind or an `out` that exists.

    InterruptionError once `should_stop`: the same export goes on later, and encodes nothing twice.
    """
    shape = common_shape(sessions, settings)
    identities = tuple(session.facts.identity for session in sessions)
    job = ExportJob(identities, tuple(shape.views), settings.fps, settings.task)
    with Staging(settings.out, job) as staging:
        plan = [(session, episode) for session in sessions for episode in session.facts.episodes]
        left = [index for index in range(len(plan)) if staging.staged(index) is None]
        frames = _Frames([plan[index][1] for index in left], settings.fps, should_stop, show)
        _encode(plan, left, EpisodeEncoder(staging, shape, settings.task, frames.step))
        staged = [one for index in range(len(plan)) if (one := staging.staged(index)) is not None]
        episodes = kept(staged)
        left_out = tuple(f"{one.session}, episode {one.number}: {one.left_out}" for one in staged if one.left_out)
        if not episodes:
            raise ExportError("\n".join(["no episode is left to export", *left_out]))
        root = staging.assembled()
        Assembly(root, staging, shape, episodes).write()
        staging.publish(root)
    return ExportSummary(len(episodes), episodes[-1].end, frames.count, left_out)


def _encode(plan: Sequence[Planned], left: Sequence[int], encoder: EpisodeEncoder) -> None:
    """Encode the episodes that are left; of a session, its signals are read once."""
    for session, members in groupby(left, key=lambda index: plan[index][0]):
        signals = session.signals()
        for index in members:
            encoder.encode(index, session, signals, plan[index][1])


class _Frames:
    """Counts the frames that are encoded; InterruptionError from `step` once the work should stop."""

    def __init__(
        self, left: Sequence[SessionEpisode], fps: int, should_stop: Callable[[], bool], show: ShowProgress
    ) -> None:
        self.count = 0
        self._total = sum(episode.end_ns - episode.begin_ns for episode in left) * fps // NS_PER_S
        self._should_stop, self._show = should_stop, show

    def step(self) -> None:
        """Before each frame."""
        if self._should_stop():
            raise InterruptionError("interrupted; the same command goes on with what is left")
        self.count += 1
        self._show("frames", self.count, self._total)


def common_shape(sessions: Sequence[RecordedSession], settings: ExportSettings) -> DatasetShape:
    """The shape that all sessions share; ExportError that says which session differs, and in what."""
    if not sessions:
        raise ExportError("there is no session to export; name one or more recordings")
    shapes = [_shape(session, settings) for session in sessions]
    for session, shape in zip(sessions, shapes, strict=True):
        for name, ours, first in zip(shape._fields, shape, shapes[0], strict=True):
            if ours != first:
                cure = "export it apart" if name != "views" else "export it apart, or name what they share with --view"
                raise ExportError(f"{session.facts.name} has other {name} than {sessions[0].facts.name}; {cure}")
    return shapes[0]


def _shape(session: RecordedSession, settings: ExportSettings) -> DatasetShape:
    facts = session.facts
    views = settings.views or tuple(facts.views)
    if unknown := [view for view in views if view not in facts.views]:
        raise ExportError(f"{facts.name} has no view {', '.join(unknown)}; it has {', '.join(facts.views) or 'none'}")
    return shape_of(facts, views, settings.fps)

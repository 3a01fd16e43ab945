"""`farhand export lerobot`: sessions checked to be of one kind, their episodes encoded, the dataset put together."""

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import NamedTuple

from common.clock import NS_PER_S
from common.errors import ExportError, InterruptionError
from farhand.export.lerobot.assembly import Assembly, kept
from farhand.export.lerobot.encoding import EpisodeEncoder
from farhand.export.lerobot.features import DatasetShape, shape_of
from farhand.export.lerobot.staging import ExportJob, Staging
from farhand.export.resampling import check_length
from farhand.export.session import MOST_PIXELS, RecordedSession, SessionEpisode, SessionFacts
from farhand.export.videos.h264 import check_size
from farhand.terminal import ShowProgress

UNNAMED = "not named"
MOST_OVERLAP = 2  # times the session: an episode whose end was lost lasts to the session's end
Planned = tuple[RecordedSession, SessionEpisode]


class ExportSettings(NamedTuple):
    """The export asked for: `fps` frames per second, these views (all without any), a task for episodes without one."""

    out: Path
    fps: int = 30
    views: tuple[str, ...] = ()
    task: str = UNNAMED


class ExportSummary(NamedTuple):
    """The outcome of an export: what was left out and why, and how many frames were encoded now."""

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
    """Write a dataset; ExportError for sessions that are not of one kind, ConfigError for an `out` that exists.

    InterruptionError once `should_stop`: the same export goes on later, and encodes nothing twice.
    """
    shape = common_shape(sessions, settings)
    identities = tuple(session.facts.identity for session in sessions)
    job = ExportJob(identities, tuple(shape.views), settings.fps, settings.task)
    with Staging(settings.out, job) as staging:
        with staging.removed_by_failure():
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
    _check_pixels(shapes[0].views)
    return shapes[0]


def _check_pixels(views: Mapping[str, tuple[int, int]]) -> None:
    for view, size_px in views.items():
        check_size(size_px, view)
    if (pixels := sum(width * height for width, height in views.values())) > MOST_PIXELS:
        raise ExportError(f"{pixels} pixels in all views, and {MOST_PIXELS} are the most; name fewer with --view")


def _check_episodes(facts: SessionFacts, fps: int) -> None:
    """ExportError for more frames than anybody exports, or episodes at one time, which are not a recorder's."""
    whole_ns = sum(max(episode.end_ns - episode.begin_ns, 0) for episode in facts.episodes)
    check_length(facts, whole_ns, fps)
    if whole_ns > MOST_OVERLAP * (facts.end_ns - facts.begin_ns):
        raise ExportError(
            f"{facts.name}: its {len(facts.episodes)} episodes overlap, together {whole_ns // NS_PER_S} s; "
            "get it again from where it was recorded, or use 'farhand export csv', which writes each instant once"
        )


def _shape(session: RecordedSession, settings: ExportSettings) -> DatasetShape:
    facts = session.facts
    _check_episodes(facts, settings.fps)
    views = settings.views or tuple(facts.views)
    if unknown := [view for view in views if view not in facts.views]:
        raise ExportError(f"{facts.name} has no view {', '.join(unknown)}; it has {', '.join(facts.views) or 'none'}")
    return shape_of(facts, views, settings.fps)

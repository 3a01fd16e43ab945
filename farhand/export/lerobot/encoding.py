"""One episode encoded into its staging folder: its frames, and a video of each view."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from msgspec.structs import replace

from common.clock import NS_PER_S
from common.errors import ExportError
from farhand.export.lerobot.features import DatasetShape, columns, operator_clock_at
from farhand.export.lerobot.staging import StagedEpisode, Staging
from farhand.export.lerobot.statistics import LEVELS, Histogram, is_sampled, levels_of
from farhand.export.lerobot.tables import frame_table
from farhand.export.resampling import ViewsAt, instants, known_from, rows_at, views_at
from farhand.export.session import RecordedSession, SessionEpisode, SessionSignals, Times, ViewPicture
from farhand.export.videos.h264 import SUFFIX, H264File, Rgb, decoded

KEY_PICTURE_EVERY = 2  # as LeRobot does: a learner reads single pictures
CRF = 20
FEWEST_FRAMES = 2
LOOK_BACK_NS = NS_PER_S  # how old the first picture of an episode may be
OnFrame = Callable[[], None]


class ViewEncoder:
    """The video of one view of an episode, and the levels of its pictures."""

    def __init__(self, path: Path, view: str, size_px: tuple[int, int], fps: int) -> None:
        self._view, self._size = view, size_px
        self._file = H264File(path, size_px, fps, KEY_PICTURE_EVERY, CRF)
        self._shown: tuple[ViewPicture, Rgb] | None = None
        self.levels: Histogram = np.zeros((3, LEVELS), np.int64)

    def add(self, picture: ViewPicture, *, sampled: bool) -> None:
        """Encode the next frame; one that is shown again is not decoded again."""
        if self._shown is None or self._shown[0] is not picture:
            self._shown = picture, self._pixels(picture)
        pixels = self._shown[1]
        if sampled:
            self.levels += levels_of(pixels)
        self._file.add(pixels)

    def finish(self) -> None:
        """Complete the video."""
        self._file.finish()

    def _pixels(self, picture: ViewPicture) -> Rgb:
        pixels = decoded(picture.jpeg, f"a picture of '{self._view}'")
        height, width = pixels.shape[:2]
        if (width, height) != self._size:
            cure = "export the sessions apart, or leave this view out: name the others with --view"
            raise ExportError(
                f"'{self._view}' has {width}x{height} pixels, and {self._size[0]}x{self._size[1]} before; {cure}"
            )
        return pixels


class EpisodeEncoder:
    """Encodes episodes of one shape into their staging folders; `on_frame` is called before each frame."""

    def __init__(self, staging: Staging, shape: DatasetShape, default_task: str, on_frame: OnFrame) -> None:
        self._staging, self._shape, self._default_task, self._on_frame = staging, shape, default_task, on_frame

    def encode(
        self, index: int, session: RecordedSession, signals: SessionSignals, episode: SessionEpisode
    ) -> StagedEpisode:
        """Encode an episode, and make it count; one that has too little is left out with the reason."""
        task = episode.task or self._default_task
        facts = session.facts
        begin_utc_ns = episode.begin_ns + facts.utc_minus_clock_ns
        staged = StagedEpisode(facts.name, begin_utc_ns, episode.number, task, episode.success, episode.note)
        at = _instants(episode, signals, self._shape.fps)
        shown, levels = self._encode_views(self._staging.begun(index), at, session, episode)
        if len(shown) < FEWEST_FRAMES:
            staged = replace(staged, left_out=_why_too_short(signals, at))
        else:
            rows = rows_at(signals, np.array([frame.instant_ns for frame in shown], np.int64))
            table = frame_table(columns(self._shape, rows, shown, episode.begin_ns))
            pq.write_table(table, self._staging.frames(index))
            sampled = sum(is_sampled(k, len(at)) for k in range(len(shown)))
            operator_ns = operator_clock_at(episode.begin_ns, rows)
            staged = replace(
                staged, length=len(shown), sampled=sampled, levels=levels, operator_clock_begin_ns=operator_ns
            )
        self._staging.complete(index, staged)
        return staged

    def _encode_views(
        self, folder: Path, at: Times, session: RecordedSession, episode: SessionEpisode
    ) -> tuple[list[ViewsAt], dict[str, list[list[int]]]]:
        """Encode all views frame by frame; which pictures each frame shows, without their data, and their levels."""
        shown: list[ViewsAt] = []
        fps, views = self._shape.fps, self._shape.views
        encoders = {view: ViewEncoder(folder / f"{view}{SUFFIX}", view, size, fps) for view, size in views.items()}
        try:
            for frame in _frames(at, session, episode, tuple(views)):
                self._on_frame()
                sampled = is_sampled(len(shown), len(at))
                for view, encoder in encoders.items():
                    encoder.add(frame.pictures[view], sampled=sampled)
                shown.append(_without_data(frame))
        finally:
            for encoder in encoders.values():
                encoder.finish()
        return shown, {view: encoder.levels.tolist() for view, encoder in encoders.items()}


def _frames(at: Times, session: RecordedSession, episode: SessionEpisode, views: Sequence[str]) -> Iterator[ViewsAt]:
    pictures = session.pictures(episode.begin_ns - LOOK_BACK_NS, episode.end_ns)
    return views_at(at, (picture for picture in pictures if picture.view in views), views)


def _without_data(frame: ViewsAt) -> ViewsAt:
    return ViewsAt(frame.instant_ns, {view: one._replace(jpeg=b"") for view, one in frame.pictures.items()})


def _instants(episode: SessionEpisode, signals: SessionSignals, fps: int) -> Times:
    """The frames' instants, from when on the signals are known."""
    known_ns = known_from(signals)
    at = instants(episode.begin_ns, episode.end_ns, fps)
    return at[:0] if known_ns is None else at[at >= known_ns]


def _why_too_short(signals: SessionSignals, at: Times) -> str:
    if known_from(signals) is None:
        return "joints, tool, gripper or what was sent are not in the recording"
    return "it is too short" if len(at) < FEWEST_FRAMES else "a view has no picture in it"

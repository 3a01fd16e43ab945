"""The dataset put together from its episodes, each encoded once: frames, videos, and what describes them."""

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from farhand.export.lerobot import statistics
from farhand.export.lerobot.features import IMAGES, Column, DatasetShape, features
from farhand.export.lerobot.staging import StagedEpisode, Staging
from farhand.export.lerobot.tables import frame_table, read_frames, write_episodes, write_frames, write_tasks
from farhand.export.videos.h264 import joined

VERSION = "v3.0"
CHUNK = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA_PATH = f"data/{CHUNK}.parquet"
VIDEO_PATH = f"videos/{{video_key}}/{CHUNK}.mp4"
EPISODES_PATH = f"meta/episodes/{CHUNK}.parquet"
FILES_PER_CHUNK, DATA_MB, VIDEO_MB = 1000, 100, 200
BYTES_PER_MB = 1 << 20


class KeptEpisode(NamedTuple):
    """An episode of the dataset: its number there, its number in the staging folder, its first frame in the dataset."""

    number: int
    staged_index: int
    begin: int
    staged: StagedEpisode

    @property
    def end(self) -> int:
        """The frame behind its last one."""
        return self.begin + self.staged.length


class FileOf(NamedTuple):
    """In which file an episode is, and how many frames of other episodes come before it there."""

    number: int
    begin: int

    @property
    def indices(self) -> dict[str, int]:
        """Chunk and file, as LeRobot counts them."""
        return {"chunk_index": self.number // FILES_PER_CHUNK, "file_index": self.number % FILES_PER_CHUNK}


class Assembly:
    """Writes one dataset into a folder; nothing is encoded here."""

    def __init__(self, root: Path, staging: Staging, shape: DatasetShape, episodes: Sequence[KeptEpisode]) -> None:
        self._root, self._staging, self._shape, self._episodes = root, staging, shape, episodes
        self._tasks = list(dict.fromkeys(episode.staged.task for episode in episodes))
        self._data = packed([staging.frames(k.staged_index) for k in episodes], episodes, DATA_MB)
        self._videos = {
            view: packed([staging.video(k.staged_index, view) for k in episodes], episodes, VIDEO_MB)
            for view in shape.views
        }

    def write(self) -> None:
        """All of it."""
        for file, members in _by_file(self._data, self._episodes):
            path = self._root / DATA_PATH.format(**file.indices)
            write_frames(path, (frame_table(self._columns(episode)) for episode in members))
        for view, files in self._videos.items():
            self._write_videos(view, files)
        write_tasks(self._root / "meta/tasks.parquet", self._tasks)
        rows = [self._row(episode) for episode in self._episodes]
        write_episodes(self._root / EPISODES_PATH.format(chunk_index=0, file_index=0), rows)
        self._write_json("meta/stats.json", self._statistics())
        self._write_json("meta/info.json", self._info())

    def _write_videos(self, view: str, files: Sequence[FileOf]) -> None:
        for file, members in _by_file(files, self._episodes):
            path = self._root / VIDEO_PATH.format(video_key=IMAGES + view, **file.indices)
            path.parent.mkdir(parents=True, exist_ok=True)
            joined([self._staging.video(episode.staged_index, view) for episode in members], path, self._shape.fps)

    def _columns(self, episode: KeptEpisode) -> dict[str, Column]:
        """The frames of an episode with their numbers in the dataset."""
        length = episode.staged.length
        return read_frames(self._staging.frames(episode.staged_index)) | {
            "episode_index": np.full(length, episode.number, np.int64),
            "index": np.arange(episode.begin, episode.end, dtype=np.int64),
            "task_index": np.full(length, self._tasks.index(episode.staged.task), np.int64),
        }

    def _row(self, episode: KeptEpisode) -> dict[str, Any]:
        """Build the dataset's row of an episode."""
        staged, fps = episode.staged, self._shape.fps
        row: dict[str, Any] = {
            "episode_index": episode.number,
            "tasks": [staged.task],
            "length": staged.length,
            "dataset_from_index": episode.begin,
            "dataset_to_index": episode.end,
            "success": staged.success,
            "note": staged.note,
            "session": staged.session,
            "begin_utc_ns": staged.begin_utc_ns,
            "operator_clock_begin_ns": staged.operator_clock_begin_ns,
            "session_episode": staged.number,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        row |= {f"data/{name}": number for name, number in self._data[episode.number].indices.items()}
        for view, files in self._videos.items():
            file, key = files[episode.number], f"videos/{IMAGES}{view}"
            row |= {f"{key}/{name}": number for name, number in file.indices.items()}
            row[f"{key}/from_timestamp"] = file.begin / fps
            row[f"{key}/to_timestamp"] = (file.begin + staged.length) / fps
        found = {name: statistics.of_column(values) for name, values in self._columns(episode).items()}
        for view in self._shape.views:
            found[IMAGES + view] = statistics.of_pictures(staged.histogram(view), staged.sampled)
        return row | {f"stats/{name}/{k}": value for name, one in found.items() for k, value in one.items()}

    def _statistics(self) -> dict[str, Any]:
        """Of the whole dataset; of the pictures, those that were sampled."""
        parts = [self._columns(episode) for episode in self._episodes]
        found = {name: statistics.of_column(np.concatenate([part[name] for part in parts])) for name in parts[0]}
        sampled = sum(episode.staged.sampled for episode in self._episodes)
        for view in self._shape.views:
            whole = statistics.summed(episode.staged.histogram(view) for episode in self._episodes)
            found[IMAGES + view] = statistics.of_pictures(whole, sampled)
        return found

    def _info(self) -> dict[str, Any]:
        return {
            "codebase_version": VERSION,
            "robot_type": self._shape.robot,
            "total_episodes": len(self._episodes),
            "total_frames": self._episodes[-1].end,
            "total_tasks": len(self._tasks),
            "chunks_size": FILES_PER_CHUNK,
            "data_files_size_in_mb": DATA_MB,
            "video_files_size_in_mb": VIDEO_MB,
            "fps": self._shape.fps,
            "splits": {"train": f"0:{len(self._episodes)}"},
            "data_path": DATA_PATH,
            "video_path": VIDEO_PATH if self._shape.views else None,
            "features": features(self._shape),
        }

    def _write_json(self, name: str, content: dict[str, Any]) -> None:
        text = json.dumps(content, indent=4, ensure_ascii=False, allow_nan=False)
        (self._root / name).write_text(text, encoding="utf-8")


def kept(staged: Sequence[StagedEpisode]) -> list[KeptEpisode]:
    """The episodes of the dataset, numbered; those left out are not among them."""
    episodes: list[KeptEpisode] = []
    for staged_index, one in enumerate(staged):
        if not one.left_out:
            begin = episodes[-1].end if episodes else 0
            episodes.append(KeptEpisode(len(episodes), staged_index, begin, one))
    return episodes


def packed(paths: Sequence[Path], episodes: Sequence[KeptEpisode], most_mb: int) -> list[FileOf]:
    """Which episodes go into one file, in their order, so that none grows beyond its size unless by one episode."""
    files: list[FileOf] = []
    number, size, frames = 0, 0, 0
    for path, episode in zip(paths, episodes, strict=True):
        more = path.stat().st_size
        if frames and size + more > most_mb * BYTES_PER_MB:
            number, size, frames = number + 1, 0, 0
        files.append(FileOf(number, frames))
        size, frames = size + more, frames + episode.staged.length
    return files


def _by_file(files: Sequence[FileOf], episodes: Sequence[KeptEpisode]) -> Iterator[tuple[FileOf, list[KeptEpisode]]]:
    """Each file with its episodes."""
    for number in sorted({file.number for file in files}):
        members = [episode for file, episode in zip(files, episodes, strict=True) if file.number == number]
        yield FileOf(number, 0), members

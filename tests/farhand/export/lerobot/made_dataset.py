"""A dataset of two made sessions, and its parts as read back."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import av
import numpy as np
import pyarrow.parquet as pq

from farhand.export.lerobot.dataset_export import ExportSettings, ExportSummary, export_lerobot
from farhand.export.session import RecordedSession
from farhand.export.videos.h264 import Rgb
from tests.farhand.export.made_session import MadeSession

FPS = 30


def made_sessions() -> list[MadeSession]:
    """Two sessions with three episodes."""
    return [MadeSession("one"), MadeSession("two", spans=((0.4, 2.0),), phase=1.0)]


def export(sessions: Sequence[RecordedSession], out: Path, **settings: Any) -> ExportSummary:
    """Export without an interruption."""
    return export_lerobot(sessions, ExportSettings(out, **settings), lambda: False, lambda *_: None)


def info(root: Path) -> dict[str, Any]:
    """What the dataset says of itself."""
    content: dict[str, Any] = json.loads((root / "meta/info.json").read_text(encoding="utf-8"))
    return content


def frames(root: Path) -> dict[str, list[Any]]:
    """All frames by column."""
    return read(root / "data/chunk-000/file-000.parquet")


def episodes(root: Path) -> list[dict[str, Any]]:
    """What the dataset says of each episode."""
    rows: list[dict[str, Any]] = pq.read_table(root / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    return rows


def read(path: Path) -> dict[str, list[Any]]:
    """A parquet file by column."""
    table: dict[str, list[Any]] = pq.read_table(path).to_pydict()
    return table


def pictures(root: Path, view: str, begin_s: float, end_s: float) -> list[Rgb]:
    """The pictures of a view from one time of its file up to another, as a learner would decode them."""
    path = root / f"videos/observation.images.{view}/chunk-000/file-000.mp4"
    with av.open(str(path)) as video:
        shown = [(float(frame.time), frame.to_ndarray(format="rgb24")) for frame in video.decode(video=0)]
    return [picture.astype(np.uint8) for time, picture in shown if begin_s - 1e-4 <= time < end_s - 1e-4]

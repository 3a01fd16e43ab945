"""What a minute of a recording takes: its pictures as JPEG, as they were sent, and the same ones as H.264; all else."""

from contextlib import ExitStack
from pathlib import Path

from common.recording.reader import RecordingReader
from farhand.export.lerobot.encoding import CRF, KEY_PICTURE_EVERY
from farhand.export.recording import open_sessions
from farhand.export.session import RecordedSession
from farhand.export.videos.h264 import SUFFIX, H264File, decoded

SECONDS_PER_MINUTE, BYTES_PER_MB = 60, 10**6
KEY_PICTURES = {"as in a LeRobot dataset": KEY_PICTURE_EVERY, "a key picture every 30": 30}
FPS = 30  # of the video's clock; x264 with constant quality spends bytes by pictures


def size_figures(file: Path, folder: Path) -> dict[str, float]:
    """Megabytes a minute, and pictures a second of all views together; videos are written into `folder`."""
    with RecordingReader(file) as recording:
        minutes = recording.seconds / SECONDS_PER_MINUTE
    with open_sessions([file]) as (session,):
        pictures = list(session.pictures(session.facts.begin_ns, session.facts.end_ns + 1))
        videos = {name: _video_bytes(session, folder, every) for name, every in KEY_PICTURES.items()}
    jpeg = sum(len(picture.jpeg) for picture in pictures)
    sizes = {"JPEG, as recorded": jpeg, "all else": file.stat().st_size - jpeg}
    sizes |= {f"the same pictures as H.264 (crf {CRF}), {name}": size for name, size in videos.items()}
    rates = {f"{name}, MB a minute": size / BYTES_PER_MB / minutes for name, size in sizes.items()}
    return {"pictures a second": len(pictures) / (SECONDS_PER_MINUTE * minutes)} | rates


def _video_bytes(session: RecordedSession, folder: Path, every: int) -> int:
    """The size of all views as videos, every recorded picture once."""
    facts = session.facts
    paths = {view: folder / f"{view}_{every}{SUFFIX}" for view in facts.views}
    with ExitStack() as stack:
        files = {view: H264File(paths[view], size, FPS, every, CRF) for view, size in facts.views.items()}
        for file in files.values():
            stack.callback(file.finish)
        for picture in session.pictures(facts.begin_ns, facts.end_ns + 1):
            files[picture.view].add(decoded(picture.jpeg, picture.view))
    return sum(path.stat().st_size for path in paths.values())

"""A recording of an hour beside the 40 s that it is made of: opened, sought in, cut and repaired; bytes a minute."""

import shutil
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from common.recording.reader import RecordingReader
from farhand.export.lerobot.encoding import CRF, KEY_PICTURE_EVERY
from farhand.export.recording import open_sessions
from farhand.export.session import RecordedSession
from farhand.export.videos.h264 import SUFFIX, H264File, decoded
from farhand.loopback.site_process import options_of
from lab.measure.recording.long_file import write_long
from lab.measure.recording.opening import opening_figures, repair_figures
from lab.stage.processes import UnavailableError, module_command, run_quietly

SECONDS, HOUR_S = 40.0, 3600.0
RECORDING_TAKES_S = 600.0
PATIENT = "safety.t_soft_ms=400", "safety.t_latch_ms=1500", "safety.longest_hold_ms=10000"
SEEKS, SEED = 10, 1
NEEDED_BYTES = 40 * 10**9
FOLDER = Path("build")
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


def measure() -> dict[str, float]:
    """The times of both files with their ratios, and the short one's bytes; meanwhile build holds a file of 20 GB."""
    FOLDER.mkdir(exist_ok=True)
    if shutil.disk_usage(FOLDER).free < NEEDED_BYTES:
        print(f"recording skipped: less than {NEEDED_BYTES / 1e9:.0f} GB are free for a file of an hour")
        return {}
    with tempfile.TemporaryDirectory(prefix="recording-", dir=FOLDER) as name:
        folder = Path(name)
        short, hour = folder / "short.mcap", folder / "hour.mcap"
        try:
            _record(short)
        except UnavailableError as error:
            sys.exit(f"recording: {error}")
        figures = size_figures(short, folder)
        write_long(short, hour, HOUR_S)
        at = np.random.default_rng(SEED).uniform(0.0, 1.0, SEEKS).tolist()
        timed = [opening_figures(file, folder, at) | repair_figures(file) for file in (short, hour)]
        figures["hour, GB"] = hour.stat().st_size / 1e9
    for key in timed[0]:
        figures |= {f"{key}, 40 s file": timed[0][key], f"{key}, hour": timed[1][key]}
        figures[f"{key}, ratio"] = timed[1][key] / timed[0][key]
    return figures


def _record(file: Path) -> None:
    """A loopback of 40 s with its recorder, which a busy machine does not end."""
    options = "--record", file, "--headless", "--seconds", SECONDS
    run_quietly(module_command("farhand", "loopback", *options, *options_of(PATIENT)), RECORDING_TAKES_S)

"""Times until a recording is open, its first scene is shown, and another time of it; whole, or cut and repaired; s."""

import os
import time
from collections.abc import Iterator, Sequence, Set
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import cast

import numpy as np
from mcap.reader import make_reader
from starlette.websockets import WebSocket

from common.clock import NS_PER_S, FakeClock
from common.errors import RecordingError
from common.recording.reader import RecordingReader
from common.recording.repair import repair
from farhand.replay.console import RecordingPlayer
from farhand.replay.playback import Playback
from farhand.replay.recorded_scene import RecordedScene
from lab.measure.recording.long_file import first_pictures_ns
from lab.stage.processes import UnavailableError
from local_site.console.model.page_messages import Play
from local_site.console.model.seat import Visitor
from local_site.console.model.shown import CAMERA_VIEW
from local_site.console.page import Page

AFTER_NS = NS_PER_S  # the beginning of all pictures


class WatchedReplay:
    """A replay whose time stands, with one page that expects these views."""

    def __init__(self, scene: RecordedScene, views: Set[str]) -> None:
        self._begin_ns = scene.begin_ns
        self._views = {CAMERA_VIEW + view for view in views}
        self._player = RecordingPlayer(scene, "a recording", Playback(FakeClock(0), scene.begin_ns, scene.end_ns))
        self._page = Page(Visitor(1, "here"), cast(WebSocket, None))  # nothing is written to it
        self._player.hub.arrive(self._page)

    def show(self, at_ns: int) -> None:
        """Jump to a time, up to all that a page then shows; UnavailableError where a view is missing."""
        at_s = (at_ns - self._begin_ns) / NS_PER_S
        self._player.handle(self._page, Play(playing=False, position_s=at_s), 0)
        self._player.feed()
        shown = set[str]()
        while (frame := self._page.slots.take()) is not None:
            shown.add(frame.view)
            self._page.taken(frame.view)
        if shown != self._views:
            raise UnavailableError(f"at {at_s:.0f} s the page has pictures of {sorted(shown)} only")


def opening_figures(file: Path, folder: Path, at: Sequence[float]) -> dict[str, float]:
    """Times to open a file, to its first scene, to those at parts (0 to 1) of its length; read from the disk again."""
    pictures_ns = first_pictures_ns(file)
    first_ns = max(pictures_ns.values()) + AFTER_NS
    figures: dict[str, float] = {}
    with _timed(figures, "open s", file), RecordingReader(file) as recording:
        last_ns = recording.span_ns[1]
    with ExitStack() as stack:
        with _timed(figures, "first scene s", file):
            scene = stack.enter_context(RecordedScene(file, folder))
            replay = WatchedReplay(scene, pictures_ns.keys())
            replay.show(first_ns)
        sought: dict[str, float] = {}
        for part in at:
            with _timed(sought, f"{part}", file):
                replay.show(round(first_ns + part * (last_ns - first_ns)))
    times = list(sought.values())
    return figures | {"seek median s": float(np.median(times)), "seek largest s": max(times)}


def repair_figures(file: Path) -> dict[str, float]:
    """Cut the file within its last chunk, and repair it; times to refuse it, to repair it, and to open it then."""
    with file.open("rb") as whole:
        summary = make_reader(whole).get_summary()
    if summary is None:
        raise UnavailableError(f"{file} has no summary to cut off")
    last = summary.chunk_indexes[-1]
    os.truncate(file, last.chunk_start_offset + last.chunk_length // 2)
    figures: dict[str, float] = {}
    with _timed(figures, "refuse a cut file s", file):
        _check_refused(file)
    with _timed(figures, "repair s", file):
        repair(file)
    with _timed(figures, "open the repaired file s", file), RecordingReader(file):
        pass
    return figures


def _check_refused(file: Path) -> None:
    try:
        with RecordingReader(file):
            raise UnavailableError("a cut file was opened")
    except RecordingError:
        return


@contextmanager
def _timed(figures: dict[str, float], name: str, file: Path) -> Iterator[None]:
    """Measure how long the block takes while the kernel has nothing of the file in memory."""
    with file.open("rb") as known:
        os.fsync(known.fileno())
        os.posix_fadvise(known.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)
    began = time.perf_counter()
    yield
    figures[name] = time.perf_counter() - began

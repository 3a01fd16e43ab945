"""A recording served as a replay, and its page."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from common.process.service import StopFlag
from farhand.replay.console import serve_replay
from farhand.replay.recorded_scene import RecordedScene
from local_site.console.config import ServeConfig
from tests.browser.opened_page import OpenedPage
from tests.farhand.replay.recorded_states import Change, recorded_states

START_S = 30.0


@dataclass
class Served:
    """A page of a replay, and what ends the program that serves it."""

    page: OpenedPage
    end: Callable[[], object]


@contextmanager
def served(browser: object, folder: Path, change: Change = lambda _: {}) -> Iterator[Served]:
    """A replay of states with these changes."""
    recorded = recorded_states(folder, change)
    heard, should_stop = SimpleNamespace(address="", ready=threading.Event()), StopFlag()

    def announce(words: str) -> None:
        heard.address = words.rpartition(" ")[2]
        heard.ready.set()

    def serve() -> None:
        with RecordedScene(recorded.file, folder) as scene:
            asyncio.run(serve_replay(scene, "a recording", ServeConfig(port=0), should_stop, announce))

    thread = threading.Thread(target=serve, name="replay", daemon=True)
    thread.start()
    assert heard.ready.wait(START_S)
    page = OpenedPage(browser, heard.address)
    page.wait_for("the timeline", lambda: "/ 0:0" in page.words("#position"))

    def end() -> None:
        should_stop.set()
        thread.join(START_S)

    yield Served(page, end)
    page.close()
    end()
    assert [error for error in page.errors if "WebSocket" not in error] == []


def jump(page: OpenedPage, seconds: float, *, playing: bool = False) -> None:
    """Pause, or play, from a time on."""
    if (page.words("#play-word") == "Pause") is not playing:
        page.page.click("#play")
        page.wait_for("the button", lambda: (page.words("#play-word") == "Pause") is playing)
    page.page.fill("#timeline", str(seconds))

"""A picture of the page in replay, paused in the middle of a recording's first engagement.

farhand loopback --record run.mcap
python -m lab.measure.page.replay_shot run.mcap docs/replay.png
"""

import asyncio
import sys
import tempfile
import threading
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from common.errors import ProcessError
from common.process.service import StopFlag
from farhand.replay.console import serve_replay
from farhand.replay.recorded_scene import RecordedScene
from lab.measure.page.chromium import CHROMIUM, QUIET, SIZE
from local_site.console.config import ServeConfig

START_S, SETTLE_MS = 30.0, 2500


def shoot(recording: Path, picture: Path) -> None:
    """Serve the recording, and take the picture."""
    should_stop, served = StopFlag(), threading.Event()
    address: list[str] = []

    def announce(words: str) -> None:
        address.append(words.rpartition(" ")[2])
        served.set()

    with tempfile.TemporaryDirectory() as folder, RecordedScene(recording, Path(folder)) as scene:
        serving = serve_replay(scene, recording.name, ServeConfig(port=0), should_stop, announce)
        thread = threading.Thread(target=lambda: asyncio.run(serving), name="replay", daemon=True)
        thread.start()
        try:
            if not served.wait(START_S):
                raise ProcessError(f"the replay has not started within {START_S:g} s")
            _take(address[0], _within_engagement(scene), picture)
        finally:
            should_stop.set()
            thread.join(START_S)


def _within_engagement(scene: RecordedScene) -> float:
    """Seconds from the beginning of the recording."""
    length_s = (scene.end_ns - scene.begin_ns) / 1e9
    times = [event.at_s for event in scene.events if event.kind == "engaged"]
    if not times:
        raise ProcessError("nothing is engaged in this recording: record a run that is")
    return (times[0] + length_s) / 2


def _take(address: str, at_s: float, picture: Path) -> None:
    with sync_playwright() as running:
        browser = running.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        page: Page = browser.new_page(viewport={"width": SIZE["width"], "height": SIZE["height"]})
        page.goto(address)
        page.wait_for_function("() => document.getElementById('play-word').textContent === 'Pause'")
        page.keyboard.press("Space")
        page.fill("#timeline", f"{at_s:.1f}")
        page.locator("#timeline").blur()
        page.wait_for_timeout(SETTLE_MS)
        page.screenshot(path=str(picture))
        browser.close()


if __name__ == "__main__":
    shoot(Path(sys.argv[1]), Path(sys.argv[2]))

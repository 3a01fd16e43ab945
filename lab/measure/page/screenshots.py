"""Pictures of the operator's page in eight states at three sizes.

    python -m lab.measure.page.screenshots [FOLDER]

writes them as PNG, dark ones, and one in light; without a folder to build/screenshots.
"""

import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from msgspec.structs import replace
from playwright.sync_api import sync_playwright

from common.clock import NS_PER_S
from common.messages.robot import LeaseState, Readiness, RobotState, SessionState
from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from lab.measure.page.bare_page import rendered
from lab.measure.page.chromium import CHROMIUM, QUIET
from local_site.console.hub import Hub
from local_site.simulation.config import SimulationConfig
from local_site.simulation.operator import SimulatedOperator
from local_site.tracking.landmarks.view_hands import as_bgr
from remote_site.video.streaming.pictures import encode_jpeg

SIZES = {"1920x1080": (1920, 1080), "1280x720": (1280, 720), "820x1180": (820, 1180)}
LIGHT = "engaged"
PERIOD_S, SHOWN_S, BUSY_S = 0.04, 2.0, 12.0
IS_LATE = "() => document.querySelector('.view:is([data-mark=old], [data-mark=slow])') !== null"
ENGAGED, DISENGAGED = SessionState.ENGAGED, SessionState.DISENGAGED

State = Callable[[], RobotState | None]
READY = Readiness(True, "ready", "ready: waiting to be engaged", False)
STOPPED = "stopped by anna; reset it, then engage"
DEAD = "process: the driver's process has been silent for 120 ms; reset it, then engage"


def anothers() -> RobotState:
    """Somebody else operates."""
    now = scene.state(ENGAGED, "ok", "the arm follows the hand")
    return replace(now, lease=LeaseState(6, "berta", 99, now.t_ns + 5 * NS_PER_S, None))


STATES: dict[str, State] = {
    "engaged": partial(scene.state, ENGAGED, "ok", "the arm follows the hand"),
    "limited": partial(
        scene.state, ENGAGED, "outside_box", "the hand asks for 45 mm beyond the workspace: the tool stays at its edge"
    ),
    "holding": partial(
        scene.state, SessionState.HOLDING, "lost", "the hand is lost: no hand is seen: hold it up before all cameras"
    ),
    "ready": partial(scene.state, DISENGAGED, "ready", "ready: waiting to be engaged", readiness=READY),
    "stopped": partial(
        scene.state, DISENGAGED, "stopped", STOPPED, readiness=Readiness(False, "stopped", STOPPED, False)
    ),
    "fault": partial(scene.state, SessionState.FAULT, "fault", DEAD, readiness=Readiness(False, "fault", DEAD, False)),
    "another operates": anothers,
    "no robot": lambda: None,
}


class StagedPage:
    """The page of a console without sites, told a state over and over."""

    def __init__(self, console: BareConsole) -> None:
        self._console = console
        self._cell = {name: encode_jpeg(image, 85) for name, image in rendered(scene.CONFIG).items()}
        pictures = SimulatedOperator(SimulationConfig()).render(0.5)
        self._own = dict(zip(("left", "right"), (encode_jpeg(as_bgr(p), 85) for p in pictures), strict=True))
        self._seq = 0

    def describe(self) -> None:
        """Say what the cell is."""
        self._console.feed(lambda hub: hub.described(scene.cell(held=False)))

    def tell(self, state: RobotState | None) -> None:
        """A state with a hand and all pictures; without a state the remote site is not there."""
        self._seq += 1
        self._console.feed(partial(Hub.hand, hand=scene.hand()))
        for name, jpeg in self._own.items():
            self._give_picture(Hub.preview, name, jpeg)
        if state is None:
            return
        self._console.feed(partial(Hub.state, state=state))
        for name, jpeg in self._cell.items():
            self._give_picture(Hub.camera, name, jpeg)

    def _give_picture(self, take: Callable[..., None], name: str, jpeg: bytes) -> None:
        frame = scene.picture(name, self._seq, jpeg)
        self._console.feed(lambda hub: take(hub, frame))


def take(folder: Path) -> list[Path]:
    """Take all pictures; the files written."""
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as running:
        browser = running.chromium.launch(executable_path=CHROMIUM, args=list(QUIET))
        files = [path for name, state in STATES.items() for path in _of_state(browser, folder, name, state)]
        browser.close()
    return files


def _of_state(browser: Any, folder: Path, name: str, state: State) -> list[Path]:
    """One state at all sizes, on a page of its own: what came before is not in its events."""
    files = []
    with BareConsole() as console:
        shown = StagedPage(console)
        page = browser.new_context().new_page()
        page.goto(console.address)
        if state() is not None:
            shown.describe()
        for size, (width, height) in SIZES.items():
            page.set_viewport_size({"width": width, "height": height})
            _let_settle(page, shown, state)
            files.append(_shoot(page, folder / f"{name} {size}.png"))
        if name == LIGHT:
            page.click("#theme")
            _let_settle(page, shown, state)
            files.append(_shoot(page, folder / f"{name} light.png"))
        page.context.close()
    return files


def _let_settle(page: Any, shown: StagedPage, state: State) -> None:
    """Tell it for a while, and on a busy machine until no picture is late."""
    began = time.monotonic()
    while (passed_s := time.monotonic() - began) < SHOWN_S or (passed_s < BUSY_S and page.evaluate(IS_LATE)):
        shown.tell(state())
        page.wait_for_timeout(1000 * PERIOD_S)


def _shoot(page: Any, path: Path) -> Path:
    page.screenshot(path=str(path))
    return path


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("build") / "screenshots"
    for file in take(target):
        sys.stdout.write(f"{file}\n")

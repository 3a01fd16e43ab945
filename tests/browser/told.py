"""A page on a console without sites, which sends the messages that a test wants, over and over."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TypeVar

from common.clock import NS_PER_MS
from common.messages.hand import HandArm
from common.messages.robot import RobotState, SessionState, Traced
from common.messages.video import CameraStatus, VideoFrame
from lab.measure.page import scene
from lab.measure.page.bare_console import BareConsole
from local_site.console.hub import Hub
from tests.browser.opened_page import PATIENCE_S, OpenedPage
from tests.present import present

SHOTS = Path(__file__).parents[2] / "build" / "screenshots"
BEAT_S = 0.05
WITHOUT_PICTURE = (CameraStatus.FROZEN, CameraStatus.MISSING)

Message = TypeVar("Message")


class Told:
    """A page, and what is sent to it over and over: the robot's state, a hand, and every camera's picture."""

    def __init__(self, console: BareConsole, page: OpenedPage) -> None:
        self.page, self._console = page, console
        self.intents, self.sites, self.clock = console.intents, console.sites, console.clock
        self.shown, self.key_frames = console.shown, console.key_frames
        self._seq = 0
        self.reset()

    def reset(self) -> None:
        """All is well."""
        self.state: Callable[..., RobotState | None] = partial(
            scene.state, SessionState.ENGAGED, "ok", "the arm follows the hand"
        )
        self.hand: Callable[[], HandArm] = scene.hand
        self.troubles: dict[str, tuple[CameraStatus, str]] = {}
        self.jpeg = scene.plain(150)
        self.age_ms = 20.0
        self.picture: Callable[[str, int], VideoFrame | None] = self._plain
        self.cameras, self.previews = scene.CAMERAS, tuple[str, ...]()
        self.is_hand_told = True

    def tell(self) -> None:
        """Everything once."""
        self._seq += 1
        self.give(Hub.state, present(self.state()))
        if self.is_hand_told:
            self.give(Hub.hand, self.hand())
        for camera in self.cameras:
            if (frame := self.picture(camera, self._seq)) is not None:
                self.give(Hub.camera, frame)
        for name in self.previews:
            self.give(Hub.preview, self._plain(name, self._seq))

    def until(self, what: str, is_so: Callable[[], bool], seconds: float = PATIENCE_S) -> float:
        """Send until a condition holds; how long it took, s."""

        def told() -> bool:
            self.tell()
            self.page.page.wait_for_timeout(1000 * BEAT_S)
            return is_so()

        return self.page.wait_for(what, told, seconds)

    def traced(self, seq: int) -> Traced:
        """A sample exposed now, and followed to the encoders; the page counts each of its numbers once."""
        exposed_ns = time.monotonic_ns()
        return Traced(7, seq, exposed_ns, *(exposed_ns + ms * NS_PER_MS for ms in (21, 26, 48)))

    def describe(self, *, held: bool = True) -> None:
        """Say what the cell is."""
        self.give(Hub.described, scene.cell(held=held))

    def mark(self, camera: str) -> str:
        return str(self.page.page.get_attribute(f"[data-name={camera}]", "data-mark"))

    def shot(self, name: str) -> None:
        SHOTS.mkdir(parents=True, exist_ok=True)
        self.page.page.screenshot(path=str(SHOTS / f"{name}.png"))

    def _plain(self, camera: str, seq: int) -> VideoFrame:
        status, reason = self.troubles.get(camera, (CameraStatus.LIVE, ""))
        jpeg = b"" if status in WITHOUT_PICTURE else self.jpeg
        return scene.picture(camera, seq, jpeg, status, reason.format(camera), self.age_ms)

    def give(self, take: Callable[[Hub, Message], None], what: Message) -> None:
        """Have the console take a message."""
        self._console.feed(lambda hub: take(hub, what))


@contextmanager
def opened_told(browser: object, script: str = "") -> Iterator[Told]:
    """A page of a console without sites, after a script; it may not have had an error."""
    with BareConsole() as console:
        page = OpenedPage(browser, console.address, script)
        told = Told(console, page)
        told.describe()
        told.until("the views", lambda: len(page.marks()) == len(scene.CAMERAS))
        yield told
        page.close()
    assert [error for error in page.errors if "WebSocket" not in error] == []

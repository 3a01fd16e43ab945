"""The pictures' own link, open only while a page is: without one no picture is drawn or sent."""

import threading
from collections.abc import Callable

from common.link.channels import CAMERA, PREVIEW, ChannelSession
from common.link.transport import open_link
from common.messages.video import VideoFrame
from local_site.calibration.control_points import CAMERAS
from local_site.console.config import ConsoleConfig
from local_site.console.listening import Listeners

Take = Callable[[VideoFrame], None]

JOIN_S = 0.5


def only_of(name: str, take: Take) -> Take:
    """Takes pictures that say they are of this camera: what is kept of each is bounded by the names that are known."""

    def taken(frame: VideoFrame) -> None:
        if frame.camera == name:
            take(frame)

    return taken


class Pictures:
    """Brings the cell's views to `camera` and the operator's to `preview`, in a thread of its own.

    `know` and `watch` may be called from anywhere and never wait.
    """

    def __init__(self, config: ConsoleConfig, listeners: Listeners, camera: Take, preview: Take) -> None:
        self._config, self._listeners = config, listeners
        self._camera, self._preview = camera, preview
        self._changed = threading.Condition()
        self._names: frozenset[str] = frozenset()
        self._watched = self._ended = False
        self._thread = threading.Thread(target=self._run, name="pictures", daemon=True)
        self._thread.start()

    def know(self, names: frozenset[str]) -> None:
        """These are the cell's cameras."""
        self._change(names=names)

    def watch(self, *, watched: bool) -> None:
        """Note whether a page is open."""
        self._change(watched=watched)

    def close(self) -> None:
        """Close the link for good."""
        self._change(ended=True)
        self._thread.join(JOIN_S)

    def _change(self, *, names: frozenset[str] | None = None, watched: bool | None = None, ended: bool = False) -> None:
        with self._changed:
            self._names = self._names if names is None else names
            self._watched = self._watched if watched is None else watched
            self._ended = self._ended or ended
            self._changed.notify_all()

    def _run(self) -> None:
        while self._wait_until(lambda: self._watched):
            names, links, cell = self._names, self._config.links, self._config.cell
            with open_link(connect=(links.video, links.local), security=links, sessions=list(ChannelSession)) as link:
                for name in names:
                    self._listeners.listen(link.latest(CAMERA, cell, name), only_of(name, self._camera))
                for name in CAMERAS if link.may_receive(PREVIEW) else ():
                    preview = link.latest(PREVIEW, cell, name, operator=self._config.name)
                    self._listeners.listen(preview, only_of(name, self._preview))
                self._wait_until(lambda: not self._watched or self._names != names)  # noqa: B023  # called here alone

    def _wait_until(self, is_so: Callable[[], bool]) -> bool:
        """Wait until a condition holds; False once closed."""
        with self._changed:
            self._changed.wait_for(lambda: self._ended or is_so())
            return not self._ended

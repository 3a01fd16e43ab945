"""The console's page fed by this process alone: no sites, no links, nothing between a picture and the browser."""

import asyncio
import threading
import time
from collections.abc import Callable
from typing import Self

import uvicorn

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate, ClockOffset
from common.messages.hand import OperatorIntent
from common.messages.recording import EpisodeOutcome
from common.messages.requests import (
    EngagementAction,
    OperatorAction,
    PicturePoint,
    RecordAction,
    Reply,
)
from common.messages.robot import Asker
from common.messages.video import KeyFrameRequest, ViewsShown
from lab.stage.waiting import until
from local_site.console.config import ServeConfig
from local_site.console.hub import Hub
from local_site.console.key_frames import KeyFrames
from local_site.console.message_handler import Outlets, PageMessageHandler
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.seat import Seat
from local_site.console.server import bind, make_server

PERIOD_S = 0.06
START_S = 10.0
UNCERTAINTY_NS = NS_PER_MS // 10
OPERATOR = "anna"


class OneClock:
    """Both sites on one clock, known almost exactly; or with a remote one that is `offset_ns` ahead."""

    round_trip_ms: float | None = 0.4
    offset_ns = 0

    def estimate(self, now_ns: int) -> ClockEstimate:
        """The offset, as of now."""
        return ClockEstimate(ClockOffset(self.offset_ns, UNCERTAINTY_NS), now_ns)


class Agreeable:
    """Answers every request with yes, unless `silent`; keeps joints `marked`, those `consented` to, acts `recorded`.

    `asked` are the requests about the engagement; the newest was of a page that had shown the halt at `seen_ns`.

    `refused` counts requests that were not answered with yes.
    """

    def __init__(self) -> None:
        self.silent = False
        self.refused = 0
        self.asked: list[EngagementAction] = []
        self.seen_ns = 0
        self.marked: list[tuple[PicturePoint, ...]] = []
        self.consented: list[Asker | None] = []
        self.recorded: list[tuple[RecordAction, EpisodeOutcome]] = []

    def engagement(
        self, action: EngagementAction, seen_ns: int = 0, _withdrawn: threading.Event | None = None
    ) -> Reply:
        """As asked."""
        self.seen_ns = seen_ns
        self.asked.append(action)
        if self.silent:
            self.refused += 1
            return Reply(id=1, done=False, code="silent", reason="nobody answers: is the site running?")
        return Reply(id=1, done=True, code="ok", reason=f"as asked: {action.value}")

    def lease(self, action: OperatorAction, to: Asker | None) -> Reply:
        """As asked."""
        self.consented.append(to)
        return Reply(id=1, done=True, code="ok", reason=f"as asked: {action.value}")

    def record(self, action: RecordAction, outcome: EpisodeOutcome) -> Reply:
        """As asked."""
        self.recorded.append((action, outcome))
        return Reply(id=1, done=True, code="ok", reason=f"as asked: {action.value}")

    def joints(self, *joints: PicturePoint) -> Reply:
        """As asked."""
        self.marked.append(joints)
        return Reply(id=1, done=True, code="ok", reason="as asked")


class BareConsole:
    """Serves the page at `address` while the block lasts; `shown`, `intents` and `key_frames` are what it has sent."""

    def __init__(self, port: int = 0) -> None:
        """`port` is where it serves, 0 any that is free."""
        self._port = port
        self.sites, self.clock = Agreeable(), OneClock()
        self.shown: list[ViewsShown] = []
        self.intents: list[OperatorIntent] = []
        self.key_frames: list[KeyFrameRequest] = []
        self.address = ""
        self.watched = False
        self._hub: Hub | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._server: uvicorn.Server | None = None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), name="bare console", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        until(lambda: self._server is not None and self._server.started, "the bare console", START_S)
        return self

    def __exit__(self, *_: object) -> None:
        if self._server is not None:
            self._server.should_exit = True
        self._thread.join(START_S)

    def feed(self, give: Callable[[Hub], object]) -> None:
        """Pass something to the hub, in its own thread."""
        if self._loop is not None and self._hub is not None:
            self._loop.call_soon_threadsafe(give, self._hub)

    def _watch(self, watched: bool) -> None:
        self.watched = watched

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        latencies, history, serve = Latencies(), History(), ServeConfig(port=self._port)
        outlets = Outlets(self.intents.append, self.shown.append)
        handler = PageMessageHandler(Seat(open_=True), outlets, self.sites, latencies, history, NS_PER_S)
        keys = KeyFrames(self.key_frames.append)
        self._hub = Hub(handler, self.clock, latencies, history, self._watch, keys, OPERATOR, operate=True)
        with bind(serve) as listening:
            port = listening.getsockname()[1]
            self.address = f"http://127.0.0.1:{port}/"
            self._server = make_server(self._hub, serve, port)
            beat = asyncio.create_task(self._update(self._hub, handler))
            await self._server.serve(sockets=[listening])
            beat.cancel()
        handler.close()

    async def _update(self, hub: Hub, handler: PageMessageHandler) -> None:
        while True:
            hub.send_situation()
            handler.send_intent(time.monotonic_ns())
            await asyncio.sleep(PERIOD_S)

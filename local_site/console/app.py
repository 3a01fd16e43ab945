"""The console: links to both sites, the hub in its event loop, the server; wiring only."""

import asyncio
import secrets
import socket
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack

import structlog
import uvicorn

from common.errors import FarhandError, ProcessError
from common.link.channels import (
    HAND,
    INTENT,
    SHOWN,
    STATE,
    ChannelSession,
)
from common.link.credentials import check_links
from common.link.transport import Link, open_link
from common.messages.requests import Description
from common.process.log import LogFormat, start_log
from common.process.service import StopFlag, notify
from local_site.console.acts import Acts
from local_site.console.cell_watch import CellWatch
from local_site.console.config import ConsoleConfig
from local_site.console.history import History
from local_site.console.hub import Hub
from local_site.console.latency import Latencies
from local_site.console.listening import Listeners
from local_site.console.page_desk import Outlets, PageDesk
from local_site.console.pictures import Pictures
from local_site.console.seat import Seat
from local_site.console.server import bind, make_server

TELL_S = 0.06
INTENT_S = 0.02
CHECK_S = 0.1
END_S = 1.9
SESSION_BITS = 62


def run_console(
    config: ConsoleConfig,
    should_stop: StopFlag,
    tell: Callable[[str], object],
    log_format: LogFormat = LogFormat.TEXT,
) -> None:
    """Serve the page until asked to stop; `tell` hears the address. FarhandError when it cannot start."""
    start_log("console", log_format)
    check_links(config.links.places, config.links, *config.bearers)
    try:
        with bind(config.serve) as listening:
            port = listening.getsockname()[1]
            console = ConsoleThread(config, listening, port)
            console.start()
            notify("READY=1")
            welcome = _welcome(config, port)
            structlog.get_logger().info("ready", cell=config.cell, page=welcome.rpartition(": ")[2])
            tell(welcome)
            while not should_stop.wait(CHECK_S):
                console.check()
                notify("WATCHDOG=1")
            notify("STOPPING=1")
            console.end()
    except FarhandError as error:
        structlog.get_logger().error("ending", reason=str(error))
        raise


def _welcome(config: ConsoleConfig, port: int) -> str:
    serve = config.serve
    name = serve.names[0] if serve.names and not serve.is_loopback else serve.host
    host = f"[{name}]" if ":" in name else name
    reach = "for this host only" if serve.is_loopback else "for every host that can reach it and knows the token"
    return f"console of cell {config.cell}: {serve.scheme}://{host}:{port}/ ({reach})"


class ConsoleThread:
    """The event loop in a thread of its own, so that the main thread can hear signals."""

    def __init__(self, config: ConsoleConfig, listening: socket.socket, port: int) -> None:
        self._config, self._listening, self._port = config, listening, port
        self._server: uvicorn.Server | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="pages", daemon=True)

    def start(self) -> None:
        """Start, and wait until pages can be served; what prevents it is raised."""
        self._thread.start()
        while self._server is None or not self._server.started:
            self.check()
            time.sleep(INTENT_S)

    def check(self) -> None:
        """Raise what ended the thread."""
        if isinstance(self._error, FarhandError):
            raise self._error
        if not self._thread.is_alive():
            raise ProcessError(f"the console's thread has died: {self._error!r}") from self._error

    def end(self) -> None:
        """Say good-bye to the pages, and end."""
        if self._server is not None:
            self._server.should_exit = True
        self._thread.join(END_S)

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:  # raised again by `check`, in the main thread
            self._error = error

    async def _serve(self) -> None:
        loop = asyncio.get_running_loop()
        with ExitStack() as stack:
            links, listeners = self._config.links, Listeners(loop)
            stack.callback(listeners.join)
            control = stack.enter_context(open_link(connect=(links.control, links.local), security=links))
            video = stack.enter_context(
                open_link(connect=(links.video,), security=links, sessions=[ChannelSession.VIDEO])
            )
            hub, desk = _wire(self._config, control, video, listeners, stack)
            self._server = make_server(hub, self._config.serve, self._port)
            async with asyncio.TaskGroup() as group:
                beats = [
                    group.create_task(_every(TELL_S, hub.tell)),
                    group.create_task(_every(INTENT_S, desk.tell_intent)),
                ]
                await self._server.serve(sockets=[self._listening])
                for beat in beats:
                    beat.cancel()
        desk.close()


def _wire(
    config: ConsoleConfig, control: Link, video: Link, listeners: Listeners, stack: ExitStack
) -> tuple[Hub, PageDesk]:
    """Put the hub between the links and the pages; the watch ends with the stack."""
    loop = asyncio.get_running_loop()
    latencies, history = Latencies(), History()

    def described(cell: Description) -> None:
        pictures.know(frozenset(camera.name for camera in cell.cameras))
        loop.call_soon_threadsafe(hub.described, cell)

    def refused(why: str) -> None:
        loop.call_soon_threadsafe(hub.refused, why)

    watch = CellWatch(control, config.cell, described, refused)
    outlets = _outlets(config, control, video) if config.operate else None
    acts = Acts(control, watch, config.cell, config.name)
    desk = PageDesk(Seat(open_=config.operate), outlets, acts, latencies, history, secrets.randbits(SESSION_BITS))
    hub = Hub(
        desk,
        watch,
        latencies,
        history,
        lambda watched: pictures.watch(watched=watched),
        config.name,
        operate=config.operate,
    )
    pictures = Pictures(config.links, config.cell, listeners, hub.camera, hub.preview)
    stack.callback(pictures.close)
    listeners.listen(control.latest(STATE, config.cell), hub.state)
    if control.may_hear(HAND):
        listeners.listen(control.latest(HAND, config.cell), hub.hand)
    stack.enter_context(watch)
    return hub, desk


def _outlets(config: ConsoleConfig, control: Link, video: Link) -> Outlets:
    name = config.name
    return Outlets(control.publisher(INTENT, config.cell, name).put, video.publisher(SHOWN, config.cell, name).put)


async def _every(period_s: float, do: Callable[[], object]) -> None:
    while True:
        do()
        await asyncio.sleep(period_s)

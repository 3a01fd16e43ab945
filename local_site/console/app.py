"""The console as a process: links to both sites, the hub and the server in one event loop; wiring only."""

import asyncio
import secrets
import socket
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial

import structlog
import uvicorn
from msgspec.structs import replace

from common.errors import FarhandError, ProcessError
from common.link.channels import HAND, INTENT, JOINTS, KEY_FRAMES, OPERATE, RECORDING, SHOWN, STATE, ChannelSession
from common.link.credentials import check_links
from common.link.engagement_client import ask_engagement
from common.link.record_client import RecordClient
from common.link.request_client import RequestClient, answered
from common.link.transport import Link, open_link
from common.messages.base import SESSION_BITS
from common.messages.recording import EpisodeOutcome
from common.messages.requests import (
    Description,
    EngagementAction,
    JointsRequest,
    OperatorAction,
    OperatorRequest,
    PicturePoint,
    RecordAction,
    Reply,
)
from common.messages.robot import Asker
from common.messages.video import ViewsShown
from common.process.log import LogFormat, log_end, start_log
from common.process.processor_wait import ProcessorWait, QueuedTime
from common.process.service import StopFlag, notify
from local_site.console.cell_watch import CellWatch
from local_site.console.config import ConsoleConfig
from local_site.console.hub import Hub
from local_site.console.key_frames import KeyFrames
from local_site.console.listening import Listeners
from local_site.console.message_handler import Outlets, PageMessageHandler
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.seat import Seat
from local_site.console.pictures import Pictures
from local_site.console.server import bind, make_server

SITUATION_S = 0.06
INTENT_S = 0.02
CHECK_S = 0.1


class SiteRequests:
    """Asks and waits, so call it from a thread that may wait; a silent site gives a refusal with a sentence."""

    def __init__(self, link: Link, watch: CellWatch, cell: str, operator: str) -> None:
        self._remote = RequestClient(link, cell, watch.clock, operator=operator)
        self._local = RequestClient(link, cell, operator=operator)
        self._recorders = RecordClient(self._remote, self._local)

    def engagement(self, action: EngagementAction, seen_ns: int = 0, withdrawn: threading.Event | None = None) -> Reply:
        """The remote site's reply to who was shown the halt at `seen_ns`; once `withdrawn` is set it is not asked."""
        return answered(lambda: ask_engagement(self._remote, action, seen_ns, withdrawn=withdrawn))

    def lease(self, action: OperatorAction, to: Asker | None) -> Reply:
        """The local site's reply; `to` is whom the page has shown to ask for the lease."""
        return answered(lambda: self._local.ask(OPERATE, partial(OperatorRequest, action=action, to=to)))

    def record(self, action: RecordAction, outcome: EpisodeOutcome) -> Reply:
        """Ask the recorders of both sites, and return what they reply."""
        return self._recorders.ask(action, outcome=outcome)

    def joints(self, shoulder: PicturePoint, elbow: PicturePoint, wrist: PicturePoint) -> Reply:
        """The local site's reply to the positions of the joints that the operator has clicked."""
        make = partial(JointsRequest, shoulder=shoulder, elbow=elbow, wrist=wrist)
        return answered(lambda: self._local.ask(JOINTS, make))


def run_console(
    config: ConsoleConfig,
    should_stop: StopFlag,
    announce: Callable[[str], object],
    log_format: LogFormat = LogFormat.TEXT,
) -> None:
    """Serve the page until asked to stop; `announce` gets the address. FarhandError when it cannot start."""
    start_log("console", log_format)
    check_links(config.links.endpoints, config.links, *config.bearers)
    with bind(config.serve) as listening:
        try:
            asyncio.run(_serve(config, listening, should_stop, announce))
        except FarhandError as error:
            structlog.get_logger().error("ending", reason=str(error))
            raise
        except Exception as error:
            structlog.get_logger().error("ending", reason=repr(error))
            raise ProcessError(f"the console has died: {error!r}") from error
    log_end()


async def _serve(
    config: ConsoleConfig, listening: socket.socket, should_stop: StopFlag, announce: Callable[[str], object]
) -> None:
    """Open the links, serve pages until asked to stop, close the links."""
    port = listening.getsockname()[1]
    with ExitStack() as stack:
        links, listeners = config.links, Listeners(asyncio.get_running_loop())
        stack.callback(listeners.join)
        control = stack.enter_context(open_link(connect=(links.control, links.local), security=links))
        video_only = [ChannelSession.VIDEO]
        video = stack.enter_context(open_link(connect=(links.video,), security=links, sessions=video_only))
        wait = ProcessorWait()
        hub, handler = _connect(config, control, video, listeners, stack, wait)
        server = make_server(hub, config.serve, port)
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(_every(SITUATION_S, hub.send_situation)),
                group.create_task(_every(INTENT_S, lambda: handler.send_intent(time.monotonic_ns()))),
                group.create_task(_measure(wait)),
                group.create_task(_watch(server, should_stop, lambda: _report_ready(config, port, announce))),
            ]
            await server.serve(sockets=[listening])
            notify("STOPPING=1")
            for task in tasks:
                task.cancel()
    handler.close()


def _connect(
    config: ConsoleConfig, control: Link, video: Link, listeners: Listeners, stack: ExitStack, wait: ProcessorWait
) -> tuple[Hub, PageMessageHandler]:
    """Put the hub between the links and the pages; the watch over the cell ends with the stack."""
    loop, cell, name = asyncio.get_running_loop(), config.cell, config.name
    latencies, history = Latencies(), History()

    def described(description: Description) -> None:
        pictures.know(frozenset(camera.name for camera in description.cameras))
        loop.call_soon_threadsafe(hub.described, description)

    def refused(why: str) -> None:
        loop.call_soon_threadsafe(hub.refused, why)

    def watched(is_watched: bool) -> None:
        pictures.watch(watched=is_watched)

    watch = CellWatch(control, cell, described, refused)
    outlets = None
    if config.operate:
        intent, shown = control.publisher(INTENT, cell, operator=name), video.publisher(SHOWN, cell, operator=name)

        def tell(views: ViewsShown) -> None:
            shown.put(replace(views, waited_ms=wait.longest_ms(time.monotonic_ns())))

        outlets = Outlets(intent.put, tell)
    requests, session = SiteRequests(control, watch, cell, name), secrets.randbits(SESSION_BITS)
    handler = PageMessageHandler(Seat(open_=config.operate), outlets, requests, latencies, history, session)
    key_frames = KeyFrames(video.publisher(KEY_FRAMES, cell).put)
    remote = config.links.control
    hub = Hub(handler, watch, latencies, history, watched, key_frames, name, operate=config.operate, remote=remote)
    pictures = Pictures(config, listeners, hub.camera, hub.preview)
    stack.callback(pictures.close)
    listeners.listen(control.latest(STATE, cell), hub.state)
    if control.may_receive(HAND):
        listeners.listen(control.latest(HAND, cell, operator=name), hub.hand)
        listeners.listen(control.latest(RECORDING, cell, operator=name), hub.recording)
    stack.enter_context(watch)
    return hub, handler


async def _every(period_s: float, do: Callable[[], object]) -> None:
    while True:
        do()
        await asyncio.sleep(period_s)


async def _measure(wait: ProcessorWait) -> None:
    """Note for how long the loop's thread waits for a processor, which takes pictures as much later."""
    queued = QueuedTime()
    while True:
        wait.turn(queued.read_ns(), time.monotonic_ns())
        await asyncio.sleep(INTENT_S)


async def _watch(server: uvicorn.Server, should_stop: StopFlag, ready: Callable[[], None]) -> None:
    """Report when pages can be served, then the loop's life to systemd; end the server when asked to stop."""
    while not server.started:
        await asyncio.sleep(INTENT_S)
    ready()
    while not should_stop():
        notify("WATCHDOG=1")
        await asyncio.sleep(CHECK_S)
    server.should_exit = True


def _report_ready(config: ConsoleConfig, port: int, announce: Callable[[str], object]) -> None:
    serve = config.serve
    name = serve.names[0] if serve.names and not serve.is_loopback else serve.host
    host = f"[{name}]" if ":" in name else name
    reach = "for this host only" if serve.is_loopback else "for every host that can reach it and knows the token"
    page = f"{serve.scheme}://{host}:{port}/ ({reach})"
    notify("READY=1")
    structlog.get_logger().info("ready", cell=config.cell, page=page)
    announce(f"console of cell {config.cell}: {page}")

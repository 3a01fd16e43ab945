"""The page's server: static files and one WebSocket per page."""

import asyncio
import logging
import socket
from functools import partial
from itertools import count
from pathlib import Path

import structlog
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from common.errors import ConfigError, MessageError, TransportError
from common.link.credentials import UNLOCK, is_locked
from common.link.port_holders import why_not_bound
from local_site.console.config import ServeConfig
from local_site.console.doorway import Doorway, DoorwayProtocol, Handshake
from local_site.console.gate import Gate
from local_site.console.hub import Hub
from local_site.console.model.seat import Visitor
from local_site.console.page import Page

STATIC = Path(__file__).parent / "static"
MAX_MESSAGE_BYTES = 16384
END_S = 0  # pages get a close message; the server waits for none
POLICY_VIOLATION, TRY_AGAIN_LATER = 1008, 1013
MOST_PAGES = 64


class PageSocket(WebSocketsSansIOProtocol):
    """Leaves pings unanswered while the page has not read what it was sent; RFC 6455 asks for the newest pong alone.

    Reading goes on meanwhile: a stop, and that the page is there, must be heard over a link that is slow the other way.
    """

    def handle_ping(self) -> None:
        """Answer, unless too much waits to be read."""
        pongs = b"".join(self.conn.data_to_send())
        if self.writable.is_set():
            self.transport.write(pongs)


def bind(serve: ServeConfig, option: str = "--set serve.port=PORT") -> socket.socket:
    """A listening socket; TransportError, which names the `option` for another port, when it cannot be bound."""
    try:
        return socket.create_server((serve.host, serve.port), family=_family(serve.host), backlog=64)
    except socket.gaierror as error:
        raise TransportError(
            f"cannot serve at {serve.host}: {error.strerror}; set serve.host to an address of this host"
        ) from error
    except OSError as error:
        another = f"another with {option}"
        raise TransportError(
            f"cannot serve at {serve.host}:{serve.port}: {why_not_bound(error, serve.port, another)}"
        ) from error


def make_server(hub: Hub, serve: ServeConfig, port: int) -> uvicorn.Server:
    """The server, to be run in the hub's event loop; ConfigError when certificate or key cannot be used."""
    config = uvicorn.Config(
        Gate(_application(hub), serve, port),
        http="h11",
        ws=PageSocket,
        ws_max_size=MAX_MESSAGE_BYTES,
        ws_per_message_deflate=False,
        lifespan="off",
        log_config=None,
        access_log=False,
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=END_S,
        ssl_certfile=serve.certificate or None,
        ssl_keyfile=serve.key or None,
    )
    for path in (serve.certificate, serve.key):
        if path and not Path(path).is_file():
            raise ConfigError(f"serve.certificate, serve.key: there is no file {path}")
    try:
        if serve.key and is_locked(serve.key):
            raise ConfigError(f"serve.key: {serve.key} {UNLOCK}")
        config.load()
    except OSError as error:  # ssl's errors are among these
        raise ConfigError(f"serve.certificate, serve.key: cannot be used: {error}") from error
    server = PageServer(config)
    library = logging.getLogger("uvicorn.error")
    library.handlers, library.propagate = [LibraryLog(server)], False
    return server


class PageServer(uvicorn.Server):
    """The library's server, with a doorway before it."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listen at sockets that are open."""
        loop, doorway, context = asyncio.get_running_loop(), Doorway(), self.config.ssl
        make = partial(
            DoorwayProtocol, doorway, config=self.config, server_state=self.server_state, app_state=self.lifespan.state
        )
        first = make if context is None else partial(Handshake, doorway, context, make)
        self.servers = [await loop.create_server(first, sock=each) for each in sockets or ()]
        self.started = True


class LibraryLog(logging.Handler):
    """Writes the server library's warnings to our log, except while the server ends."""

    def __init__(self, server: uvicorn.Server) -> None:
        super().__init__(logging.WARNING)
        self._server = server

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line."""
        if not self._server.should_exit:
            structlog.get_logger().log(record.levelno, "server", reason=self.format(record))


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


def _application(hub: Hub) -> Starlette:
    numbers, talking = count(1), set[Page]()

    async def index(_request: Request) -> FileResponse:
        return FileResponse(STATIC / "index.html")

    async def talk(connection: WebSocket) -> None:
        await connection.accept()
        if len(talking) >= MOST_PAGES:
            await connection.close(TRY_AGAIN_LATER, f"{MOST_PAGES} pages are open: close one")
            return
        address = connection.client.host if connection.client is not None else "unknown"
        page = Page(Visitor(next(numbers), address), connection)
        talking.add(page)
        try:
            await _serve_page(hub, page, connection)
        finally:
            talking.discard(page)

    routes = [
        Route("/", index),
        WebSocketRoute("/page", talk),
        Mount("/static", StaticFiles(directory=STATIC)),
    ]
    return Starlette(routes=routes)


async def _serve_page(hub: Hub, page: Page, connection: WebSocket) -> None:
    hub.arrive(page)
    writing = asyncio.create_task(page.write())
    try:
        async for text in connection.iter_text():
            hub.receive(page, text)
    except MessageError as error:
        await connection.close(POLICY_VIOLATION, str(error)[:100])
    except KeyError:  # a binary message has no text
        await connection.close(POLICY_VIOLATION, "messages are text")
    except (WebSocketDisconnect, WebSocketDisconnected):  # noticed while reading, or while writing
        return
    finally:
        hub.leave(page)
        writing.cancel()

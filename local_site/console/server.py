"""The page's server: static files and one WebSocket per page."""

import asyncio
import logging
import socket
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

from common.errors import ConfigError, MessageError, TransportError
from local_site.console.config import ServeConfig
from local_site.console.gate import Gate
from local_site.console.hub import Hub
from local_site.console.model.seat import Visitor
from local_site.console.page import Page

STATIC = Path(__file__).parent / "static"
MAX_MESSAGE_BYTES = 16384
END_S = 0  # pages get a close message; the server waits for none
POLICY_VIOLATION = 1008


def bind(serve: ServeConfig, option: str = "--set serve.port=PORT") -> socket.socket:
    """A listening socket; TransportError, which names the `option` for another port, when it cannot be bound."""
    try:
        return socket.create_server((serve.host, serve.port), family=_family(serve.host), backlog=64)
    except socket.gaierror as error:
        raise TransportError(
            f"cannot serve at {serve.host}: {error.strerror}; set serve.host to an address of this host"
        ) from error
    except OSError as error:
        raise TransportError(
            f"cannot serve at {serve.host}:{serve.port}: {error.strerror}; choose another with {option}"
        ) from error


def make_server(hub: Hub, serve: ServeConfig, port: int) -> uvicorn.Server:
    """The server, to be run in the hub's event loop; ConfigError when certificate or key cannot be used."""
    config = uvicorn.Config(
        Gate(_application(hub), serve, port),
        http="h11",
        ws="websockets-sansio",
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
        config.load()
    except OSError as error:  # ssl's errors are among these
        raise ConfigError(f"serve.certificate, serve.key: cannot be used: {error}") from error
    server = uvicorn.Server(config)
    library = logging.getLogger("uvicorn.error")
    library.handlers, library.propagate = [LibraryLog(server)], False
    return server


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
    numbers = count(1)

    async def index(_request: Request) -> FileResponse:
        return FileResponse(STATIC / "index.html")

    async def talk(connection: WebSocket) -> None:
        await connection.accept()
        address = connection.client.host if connection.client is not None else "unknown"
        await _serve_page(hub, Page(Visitor(next(numbers), address), connection), connection)

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

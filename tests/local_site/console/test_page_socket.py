"""A page that pings and never reads the pongs takes no memory of the console, and is still heard."""

import asyncio
from types import SimpleNamespace
from typing import Any

import uvicorn

from local_site.console.server import PageSocket

MASK = b"\0\0\0\0"
HANDSHAKE = (
    b"GET /page HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
PING = b"\x89\xfd" + MASK + b"x" * 125
PONG = b"\x8a\x7d" + b"x" * 125
STOP = b"\x81\x84" + MASK + b"stop"
CHUNK = 500


class Unread:
    """A transport that keeps what is written, and pauses the writer as asyncio's does: once, above the limit."""

    def __init__(self, protocol: PageSocket, limit_bytes: int) -> None:
        self._protocol, self._limit_bytes = protocol, limit_bytes
        self.kept, self._paused = b"", False

    def write(self, data: bytes) -> None:
        self.kept += data
        if len(self.kept) > self._limit_bytes and not self._paused:
            self._paused = True
            self._protocol.pause_writing()

    def read(self) -> bytes:
        """What waited, as the page reads it."""
        kept, self.kept = self.kept, b""
        if self._paused:
            self._paused = False
            self._protocol.resume_writing()
        return kept

    def get_extra_info(self, _name: str) -> None:
        return None

    def is_closing(self) -> bool:
        return False

    def pause_reading(self) -> None: ...

    def resume_reading(self) -> None: ...

    def close(self) -> None: ...


class Talk:
    """The page's side of a connection whose application keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[str] = []
        config = uvicorn.Config(self._application, ws=PageSocket, ws_per_message_deflate=False, interface="asgi3")
        config.load()
        state: Any = SimpleNamespace(connections=set(), tasks=set(), default_headers=[])
        self.socket = PageSocket(config=config, server_state=state, app_state={})
        self.wire = Unread(self.socket, 10 * len(PONG))
        self.socket.connection_made(self.wire)  # type: ignore[arg-type]  # what it needs of a transport

    async def _application(self, _scope: Any, receive: Any, send: Any) -> None:
        await send({"type": "websocket.accept"})
        while (message := await receive())["type"] != "websocket.disconnect":
            self.told.append(message.get("text", ""))

    async def say(self, data: bytes) -> None:
        """Send this, and let the application run."""
        self.socket.data_received(data)
        for _ in range(5):
            await asyncio.sleep(0)


def test_pongs_that_nobody_reads_are_not_kept_and_a_stop_among_the_pings_is_heard() -> None:
    async def talk() -> None:
        page = Talk()
        await page.say(HANDSHAKE)
        assert page.wire.read().startswith(b"HTTP/1.1 101")
        for _ in range(20):
            await page.say(PING * CHUNK)
        assert len(page.wire.kept) <= CHUNK * len(PONG)  # of the first chunk, all of which was read together
        await page.say(STOP + PING)
        assert page.told[-1] == "stop"
        page.wire.read()
        await page.say(PING)
        assert page.wire.read() == PONG
        page.socket.connection_lost(None)
        await asyncio.sleep(0)

    asyncio.run(talk())

"""The pages: what waits to be sent to each, never more than the newest of everything."""

import asyncio
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
from starlette.websockets import WebSocket, WebSocketDisconnect

from local_site.console.model.frames import FrameSlots, ViewFrame
from local_site.console.model.seat import Visitor

MOST_MESSAGES = 64


class Page:
    """The sending side of one connection; `write` runs as a task parallel to the reader."""

    def __init__(self, visitor: Visitor, socket: WebSocket) -> None:
        self.visitor = visitor
        self.slots = FrameSlots()
        self._socket = socket
        self._messages: deque[str] = deque(maxlen=MOST_MESSAGES)
        self._newest: dict[str, str] = {}
        self._wake = asyncio.Event()

    def frame(self, frame: ViewFrame) -> bool:
        """Send a new picture; False for one that the page could not decode."""
        self._wake.set()
        return self.slots.offer(frame)

    def taken(self, view: str) -> None:
        """The page is done with a picture and can take another."""
        self.slots.taken(view)
        self._wake.set()

    def newest(self, kind: str, text: str) -> None:
        """Send the newest of a kind; it replaces one that has not been sent yet."""
        self._newest[kind] = text
        self._wake.set()

    def send(self, **fields: Any) -> None:
        """Send something once, such as an answer."""
        self._messages.append(msgspec.json.encode(fields).decode())
        self._wake.set()

    async def write(self) -> None:
        """Send what waits, as fast as the page takes it, until it is gone."""
        try:
            while await self._wake.wait():
                self._wake.clear()
                await self._write_all()
        except WebSocketDisconnect:
            return

    async def _write_all(self) -> None:
        while True:
            while self._messages:
                await self._socket.send_text(self._messages.popleft())
            while self._newest:
                await self._socket.send_text(self._newest.pop(next(iter(self._newest))))
            frame = self.slots.take()
            if frame is None:
                return
            await self._socket.send_bytes(frame.payload)


class OpenPages:
    """The pages that are connected; `watched` is called with whether there is any."""

    def __init__(self, watched: Callable[[bool], None]) -> None:
        self._watched = watched
        self._pages: list[Page] = []

    def __iter__(self) -> Iterator[Page]:
        return iter(self._pages)

    def __bool__(self) -> bool:
        return bool(self._pages)

    def add(self, page: Page) -> None:
        """A page has connected."""
        self._pages.append(page)
        self._watched(True)

    def remove(self, page: Page) -> None:
        """A page has gone."""
        self._pages.remove(page)
        self._watched(bool(self._pages))

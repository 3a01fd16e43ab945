"""One page: what waits to be sent to it, never more than the newest of everything."""

import asyncio
from collections import deque
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
        self._situation: str | None = None
        self._wake = asyncio.Event()

    def frame(self, frame: ViewFrame) -> None:
        """Send a new picture."""
        self.slots.offer(frame)
        self._wake.set()

    def taken(self, view: str) -> None:
        """The page is done with a picture and can take another."""
        self.slots.taken(view)
        self._wake.set()

    def situation(self, text: str) -> None:
        """Send the situation; it replaces one that has not been sent yet."""
        self._situation = text
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
            if self._situation is not None:
                text, self._situation = self._situation, None
                await self._socket.send_text(text)
            frame = self.slots.take()
            if frame is None:
                return
            await self._socket.send_bytes(frame.payload)

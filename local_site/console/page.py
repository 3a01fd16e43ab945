"""One page: what waits to be sent to it, never more than the newest of everything."""

import asyncio
from collections import deque
from typing import Any

import msgspec
from starlette.websockets import WebSocket, WebSocketDisconnect

from local_site.console.frame_slots import FrameSlots, ViewFrame
from local_site.console.seat import Visitor

MOST_LETTERS = 64


class Page:
    """The sending side of one connection; `write` runs as a task beside the reader."""

    def __init__(self, visitor: Visitor, socket: WebSocket) -> None:
        self.visitor = visitor
        self.slots = FrameSlots()
        self._socket = socket
        self._letters: deque[str] = deque(maxlen=MOST_LETTERS)
        self._situation: str | None = None
        self._wake = asyncio.Event()

    def frame(self, frame: ViewFrame) -> None:
        """A new picture."""
        self.slots.offer(frame)
        self._wake.set()

    def taken(self, view: str) -> None:
        """The page is done with a picture and can take another."""
        self.slots.taken(view)
        self._wake.set()

    def situation(self, told: str) -> None:
        """The situation anew; one that was not sent yet is replaced."""
        self._situation = told
        self._wake.set()

    def letter(self, **fields: Any) -> None:
        """Something that is said once, as an answer."""
        self._letters.append(msgspec.json.encode(fields).decode())
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
            while self._letters:
                await self._socket.send_text(self._letters.popleft())
            if self._situation is not None:
                told, self._situation = self._situation, None
                await self._socket.send_text(told)
            frame = self.slots.take()
            if frame is None:
                return
            await self._socket.send_bytes(frame.payload)

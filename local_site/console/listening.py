"""Passes messages from the links' threads to the event loop: only the newest few, however busy the loop is."""

import asyncio
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

from common.errors import MessageError, TransportError
from common.link.pubsub import Latest
from common.messages.base import Message
from common.process.log import RefusalLog

M = TypeVar("M", bound=Message)

JOIN_S = 0.5


class Handover(Generic[M]):
    """Passes the `depth` newest messages to `take` in the loop, in order; they replace older ones that still wait."""

    def __init__(self, loop: asyncio.AbstractEventLoop, take: Callable[[M], None], depth: int) -> None:
        self._loop, self._take = loop, take
        self._waiting: deque[M] = deque(maxlen=depth)

    def put(self, message: M) -> None:
        """Queue a message for the loop; may be called from any thread."""
        self._waiting.append(message)
        self._loop.call_soon_threadsafe(self._deliver)

    def _deliver(self) -> None:
        if self._waiting:
            self._take(self._waiting.popleft())


class Listeners:
    """One thread per subscription, until its link is closed."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self._loop = loop
        self._threads: list[threading.Thread] = []

    def listen(self, latest: Latest[M], take: Callable[[M], None]) -> None:
        """Pass on each message, until the link or the loop is closed."""
        thread = threading.Thread(
            target=_listen, args=(latest, Handover(self._loop, take, latest.depth)), name="listen", daemon=True
        )
        thread.start()
        self._threads = [*(each for each in self._threads if each.is_alive()), thread]

    def join(self) -> None:
        """Wait for the threads once the links are closed: none may still use a link when the process ends."""
        deadline = time.monotonic() + JOIN_S
        for thread in self._threads:
            thread.join(max(0.0, deadline - time.monotonic()))


def _listen(latest: Latest[M], handover: Handover[M]) -> None:
    refusals = RefusalLog()
    while True:
        try:
            handover.put(latest.wait())
        except MessageError as error:
            refusals.note(error)
        except (TransportError, RuntimeError):  # the link or the loop is closed
            return

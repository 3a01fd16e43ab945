"""A link of limited bandwidth between two programs of this host: a TCP proxy."""

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable
from typing import Self

from common.clock import NS_PER_S
from common.host_clock import MonotonicClock

CHUNK_BYTES = 4096
BUFFER_BYTES = 32768  # a short queue, so that the sender soon notices how much the link carries
START_S = 5.0


class NarrowLink:
    """Forwards connections from `port` to another while the block lasts; only the return direction is limited.

    `mbit_s` may be changed while it runs; `carried_bytes` counts what was carried back.
    """

    def __init__(self, port: int, to_port: int, mbit_s: float) -> None:
        self.mbit_s = mbit_s
        self.carried_bytes = 0
        self._port, self._to_port = port, to_port
        self._clock = MonotonicClock()
        self._free_ns = 0
        self._ready = threading.Event()
        self._ended: Callable[[], object] = lambda: None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), name="link", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        self._ready.wait(START_S)
        return self

    def __exit__(self, *_: object) -> None:
        self._ended()
        self._thread.join(START_S)

    async def _serve(self) -> None:
        loop, ended = asyncio.get_running_loop(), asyncio.Event()
        server = await asyncio.start_server(self._carry, "127.0.0.1", self._port, limit=BUFFER_BYTES)
        self._ended = lambda: loop.call_soon_threadsafe(ended.set)
        self._ready.set()
        await ended.wait()
        server.close()

    async def _carry(self, near_in: asyncio.StreamReader, near_out: asyncio.StreamWriter) -> None:
        with contextlib.suppress(OSError), contextlib.closing(near_out):  # one side is gone, and so is the connection
            far_in, far_out = await asyncio.open_connection(sock=await self._far_side(), limit=BUFFER_BYTES)
            with contextlib.closing(far_out):
                near_out.transport.set_write_buffer_limits(high=BUFFER_BYTES)
                await asyncio.gather(
                    self._pump(near_in, far_out, limited=False), self._pump(far_in, near_out, limited=True)
                )

    async def _far_side(self) -> socket.socket:
        far = socket.socket()
        far.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        far.setblocking(False)
        try:
            await asyncio.get_running_loop().sock_connect(far, ("127.0.0.1", self._to_port))
        except OSError:
            far.close()
            raise
        return far

    async def _pump(self, source: asyncio.StreamReader, sink: asyncio.StreamWriter, *, limited: bool) -> None:
        while data := await source.read(CHUNK_BYTES):
            if limited:
                await self._wait_for_capacity(len(data))
                self.carried_bytes += len(data)
            sink.write(data)
            await sink.drain()
        sink.close()

    async def _wait_for_capacity(self, size: int) -> None:
        """Wait until the link has carried everything before this, and this."""
        now_ns = self._clock.now_ns()
        self._free_ns = max(self._free_ns, now_ns) + round(8e-6 * size / self.mbit_s * NS_PER_S)
        await asyncio.sleep((self._free_ns - now_ns) / NS_PER_S)

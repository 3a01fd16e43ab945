"""Requests of pages to the sites, in threads that may wait; each page is answered when its own is done."""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from common.clock import NS_PER_MS
from common.messages.requests import Reply
from local_site.console.model.history import History
from local_site.console.page import Page


class RequestPools:
    """Lives in the event loop; a stop never waits behind another request."""

    def __init__(self, history: History) -> None:
        self._history = history
        self._tasks: set[asyncio.Task[None]] = set()
        self._stopping = ThreadPoolExecutor(2, "stop")
        self._asking = ThreadPoolExecutor(2, "ask")

    def close(self) -> None:
        """Begin nothing more, and wait for the requests under way: their link is closed, so it is short."""
        for pool in (self._stopping, self._asking):
            pool.shutdown(cancel_futures=True)

    def stop(self, page: Page, number: int, act: Callable[[], Reply]) -> None:
        """Request a stop."""
        self._start(page, number, self._stopping, act, "stop")

    def ask(self, page: Page, number: int, act: Callable[[], Reply], what: str) -> None:
        """Request anything else; `what` names it to the page and in the history."""
        self._start(page, number, self._asking, act, what)

    def _start(self, page: Page, number: int, pool: ThreadPoolExecutor, act: Callable[[], Reply], what: str) -> None:
        asked_ns = time.monotonic_ns()

        async def ask() -> None:
            reply = await asyncio.get_running_loop().run_in_executor(pool, act)
            now_ns = time.monotonic_ns()
            took_ms = (now_ns - asked_ns) / NS_PER_MS
            outcome = f"done in {took_ms:.0f} ms" if reply.done else "refused"
            self._history.note(what, f"{what} {outcome}: {reply.reason}", now_ns)
            answer(page, number, what, reply, took_ms)

        task = asyncio.get_running_loop().create_task(ask())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def answer(page: Page, number: int, what: str, reply: Reply, took_ms: float = 0.0) -> None:
    """Answer a page's request of this number."""
    done, code, reason = reply.done, reply.code, reply.reason
    page.send(type="answer", id=number, what=what, done=done, code=code, reason=reason, took_ms=took_ms)

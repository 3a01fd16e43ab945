"""Requests of pages to the sites, in threads that may wait; each page is answered when its own is done."""

import asyncio
import threading
import time
from collections import defaultdict, deque
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor

from common.clock import NS_PER_MS
from common.messages.requests import WAITING, Reply
from local_site.console.model.history import History
from local_site.console.page import Page

MOST_WAITING = 8  # more than a person has under way
BUSY = Reply(id=0, done=False, code="busy", reason=f"{MOST_WAITING} requests are not answered yet: wait for them")

Act = Callable[[], Reply]
Numbers = deque[tuple[int, int]]  # of requests, with when each was made, ns


class RequestPools:
    """Lives in the event loop; `stop` asks for a stop, which never waits behind another request.

    However many stops pages ask for, one is under way at a time, and the next is all of theirs who ask meanwhile: the
    arm may have been reset since the one under way. `standing` is set once a later stop, or end of the engagement,
    withdraws what is asked for now.
    """

    def __init__(self, history: History, stop: Act) -> None:
        self._history, self._act_of_stop = history, stop
        self._tasks: set[asyncio.Task[None]] = set()
        self._stopping = ThreadPoolExecutor(1, "stop")
        self._asking = ThreadPoolExecutor(2, "ask")
        self._waiting = 0
        self._stops: defaultdict[Page, Numbers] = _no_stops()
        self._is_stopping = False
        self.standing = threading.Event()

    def close(self) -> None:
        """Begin nothing more, and wait for the requests under way: their link is closed, so it is short."""
        for pool in (self._stopping, self._asking):
            pool.shutdown(cancel_futures=True)

    def stop(self, page: Page, number: int) -> None:
        """Request a stop; of those of one page that wait only the newest are answered."""
        self.withdraw()
        self._stops[page].append((number, time.monotonic_ns()))
        if not self._is_stopping:
            self._is_stopping = True
            self._begin(self._stop())

    def withdraw(self) -> None:
        """Nothing that moves the arm and was asked for until now is sent any more: it would overtake what comes now."""
        self.standing.set()
        self.standing = threading.Event()

    def ask(self, page: Page, number: int, act: Act, what: str) -> None:
        """Request anything else; `what` names it to the page and in the history."""
        if self._waiting == MOST_WAITING:
            answer(page, number, what, BUSY)
            return
        self._waiting += 1
        self._begin(self._ask(page, number, act, what))

    async def _stop(self) -> None:
        try:
            while self._stops:
                asked, self._stops = self._stops, _no_stops()
                reply = await asyncio.get_running_loop().run_in_executor(self._stopping, self._act_of_stop)
                for page, numbers in asked.items():
                    for number, asked_ns in numbers:
                        self._done(page, number, "stop", reply, asked_ns)
        finally:
            self._is_stopping = False

    async def _ask(self, page: Page, number: int, act: Act, what: str) -> None:
        asked_ns = time.monotonic_ns()
        try:
            reply = await asyncio.get_running_loop().run_in_executor(self._asking, act)
        finally:
            self._waiting -= 1
        self._done(page, number, what, reply, asked_ns)

    def _done(self, page: Page, number: int, what: str, reply: Reply, asked_ns: int) -> None:
        now_ns = time.monotonic_ns()
        took_ms = (now_ns - asked_ns) / NS_PER_MS
        outcome = f"done in {took_ms:.0f} ms" if reply.done else "waits" if reply.code == WAITING else "refused"
        note = self._history.note if reply.done else self._history.note_once
        note(what, f"{what} {outcome}: {reply.reason}", now_ns)
        answer(page, number, what, reply, took_ms)

    def _begin(self, work: Coroutine[None, None, None]) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _no_stops() -> defaultdict[Page, Numbers]:
    return defaultdict(lambda: deque(maxlen=MOST_WAITING))


def answer(page: Page, number: int, what: str, reply: Reply, took_ms: float = 0.0) -> None:
    """Answer a page's request of this number."""
    done, code, reason = reply.done, reply.code, reply.reason
    page.send(type="answer", id=number, what=what, done=done, code=code, reason=reason, took_ms=took_ms)

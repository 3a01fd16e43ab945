"""Handles the pages' messages: who operates, the operator's intent, and requests to the sites."""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol, assert_never

from msgspec.structs import replace

from common.clock import NS_PER_MS, ClockOffset
from common.messages.hand import Intent, OperatorIntent
from common.messages.requests import EngagementAction, OperatorAction, PicturePoint, Reply
from common.messages.video import VideoFrame, ViewsShown
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.page_messages import (
    AnyPageMessage,
    Ask,
    AskLease,
    Beat,
    Clutch,
    FrameTaken,
    LeaveSeat,
    MarkJoints,
    Shown,
    Steer,
    TakeSeat,
)
from local_site.console.model.seat import Seat, SeatAnswer
from local_site.console.model.shown import ShownViews
from local_site.console.page import Page

NO_LEASE = 0


class Requests(Protocol):
    """Asks the sites and waits for the answer."""

    def engagement(self, action: EngagementAction) -> Reply: ...

    def lease(self, action: OperatorAction) -> Reply: ...

    def joints(self, shoulder: PicturePoint, elbow: PicturePoint, wrist: PicturePoint) -> Reply: ...


@dataclass(frozen=True, slots=True)
class Outlets:
    """Where the operator's intent and what is shown go."""

    intent: Callable[[OperatorIntent], object]
    shown: Callable[[ViewsShown], object]


class PageMessageHandler:
    """Lives in the event loop; every method is called there. Any page may stop the arm, the rest is the operator's.

    `lease` is the number of the lease that this console's operator last held. Without outlets, where pages
    only watch, nothing is sent to the sites.
    """

    def __init__(
        self,
        seat: Seat,
        outlets: Outlets | None,
        requests: Requests,
        latencies: Latencies,
        history: History,
        session: int,
    ) -> None:
        self.seat, self.intent = seat, Intent()
        self.lease = NO_LEASE
        self._outlets, self._requests = outlets, requests
        self._latencies, self._history = latencies, history
        self._shown = ShownViews(session)
        self._tasks: set[asyncio.Task[None]] = set()
        self._stopping = ThreadPoolExecutor(2, "stop")  # a stop never waits behind another request
        self._asking = ThreadPoolExecutor(2, "ask")

    def close(self) -> None:
        """Begin nothing more, and wait for the requests under way: their link is closed, so it is short."""
        for pool in (self._stopping, self._asking):
            pool.shutdown(cancel_futures=True)

    def send_intent(self) -> None:
        """Send the operating page's intent to the local site; without such a page nothing is sent, and none held."""
        now_ns = time.monotonic_ns()
        if self.seat.occupant is None or self._outlets is None:
            return
        intent = replace(self.intent, hold=self.seat.held(now_ns))
        self._outlets.intent(OperatorIntent(sent_ns=now_ns, intent=intent))

    def remember(self, view: str, frame: VideoFrame, now_ns: int, clock: ClockOffset | None) -> None:
        """A frame of the cell goes to the pages under this name of its view; `clock` is the remote one, if known."""
        self._shown.remember(view, frame, now_ns, clock.offset_ns if clock is not None else None)

    def handle(self, page: Page, message: AnyPageMessage, now_ns: int) -> None:
        """Carry out what a page asks for."""
        match message:
            case Beat():
                self.seat.beat(page.visitor, now_ns, down=message.down)
                page.send(type="echo", page_ms=message.page_ms, server_ms=now_ns / NS_PER_MS)
            case FrameTaken():
                page.taken(message.view)
            case Ask():
                self._ask(page, message, now_ns)
            case AskLease():
                self._if_operating(
                    page, message.id, lambda: self._requests.lease(message.action), f"lease: {message.action.value}"
                )
            case MarkJoints():
                joints = message.shoulder, message.elbow, message.wrist
                self._if_operating(page, message.id, lambda: self._requests.joints(*joints), "joints")
            case TakeSeat():
                self._answer_seat(page, message.id, self.seat.take(page.visitor, now_ns), now_ns)
            case LeaveSeat():
                self._answer_seat(page, message.id, self.seat.leave(page.visitor), now_ns)
            case Shown() | Clutch() | Steer():
                if page.visitor == self.seat.occupant:
                    self._operate(message, now_ns)
            case _:
                assert_never(message)

    def _operate(self, message: Shown | Clutch | Steer, now_ns: int) -> None:
        match message:
            case Clutch():
                self.intent = replace(self.intent, clutch_count=self.intent.clutch_count + 1)
                self._history.note("operator", "new origins taken (clutch)", now_ns)
            case Steer():
                self.intent = message.apply(self.intent)
            case Shown():
                self._report(message, now_ns)
            case _:
                assert_never(message)

    def _report(self, message: Shown, now_ns: int) -> None:
        shown = self._shown.message(message.views, self.lease, now_ns)
        if shown is None:
            return
        for camera, view in shown.views.items():
            self._latencies.painted(camera, view.capture_ns, view.age_ms, now_ns)
        if self._outlets is not None:
            self._outlets.shown(shown)

    def _ask(self, page: Page, message: Ask, now_ns: int) -> None:
        if message.action is not EngagementAction.STOP:
            self._if_operating(
                page, message.id, lambda: self._requests.engagement(message.action), message.action.value
            )
            return
        self.seat.interrupt()
        self._history.note("stop", f"stop asked by {page.visitor}", now_ns)
        self._later(page, message.id, self._stopping, lambda: self._requests.engagement(message.action), "stop")

    def _if_operating(self, page: Page, number: int, act: Callable[[], Reply], what: str) -> None:
        if page.visitor == self.seat.occupant:
            self._later(page, number, self._asking, act, what)
            return
        who = f"{self.seat.occupant} operates" if self.seat.occupant is not None else "nobody operates"
        reason = f"this page only watches: {who}; take the controls first"
        _answer(page, number, what, Reply(id=number, done=False, code="watching", reason=reason))

    def _answer_seat(self, page: Page, number: int, verdict: SeatAnswer, now_ns: int) -> None:
        if verdict.done:
            self._history.note("seat", f"{page.visitor}: {verdict.sentence}", now_ns)
        _answer(page, number, "controls", Reply(id=number, done=verdict.done, code="seat", reason=verdict.sentence))

    def _later(self, page: Page, number: int, pool: ThreadPoolExecutor, act: Callable[[], Reply], what: str) -> None:
        """Ask in a thread that may wait, and answer the page when it is done."""
        asked_ns = time.monotonic_ns()

        async def ask() -> None:
            reply = await asyncio.get_running_loop().run_in_executor(pool, act)
            now_ns = time.monotonic_ns()
            took_ms = (now_ns - asked_ns) / NS_PER_MS
            outcome = f"done in {took_ms:.0f} ms" if reply.done else "refused"
            self._history.note(what, f"{what} {outcome}: {reply.reason}", now_ns)
            _answer(page, number, what, reply, took_ms)

        task = asyncio.get_running_loop().create_task(ask())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)


def _answer(page: Page, number: int, what: str, reply: Reply, took_ms: float = 0.0) -> None:
    done, code, reason = reply.done, reply.code, reply.reason
    page.send(type="answer", id=number, what=what, done=done, code=code, reason=reason, took_ms=took_ms)

"""Does what pages ask: who operates, the operator's intent, and what is asked of the sites."""

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Protocol, assert_never

import msgspec

from common.clock import NS_PER_MS, ClockOffset
from common.messages.hand import Intent, OperatorIntent
from common.messages.requests import (
    EngagementAction,
    OperatorAction,
    PicturePoint,
    Reply,
)
from common.messages.video import VideoFrame, ViewsShown
from local_site.console.history import History
from local_site.console.latency import Latencies
from local_site.console.page import Page
from local_site.console.page_messages import (
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
from local_site.console.seat import Seat, SeatAnswer
from local_site.console.shown import ShownViews

NO_LEASE = 0


class Acting(Protocol):
    """Asks the sites and waits for the answer."""

    def engagement(self, action: EngagementAction) -> Reply: ...

    def lease(self, action: OperatorAction) -> Reply: ...

    def joints(self, shoulder: PicturePoint, elbow: PicturePoint, wrist: PicturePoint) -> Reply: ...


@dataclass(frozen=True, slots=True)
class Outlets:
    """Where the operator's intent and what is shown go."""

    intent: Callable[[OperatorIntent], object]
    shown: Callable[[ViewsShown], object]


class PageDesk:
    """Lives in the event loop; every method is called there. Anybody may stop the arm, the rest is the operator's.

    `lease` is the number of the lease that this console's operator holds, as last heard. Without outlets, as where all
    only watch, nothing is told to the sites.
    """

    def __init__(
        self, seat: Seat, outlets: Outlets | None, acts: Acting, latencies: Latencies, history: History, session: int
    ) -> None:
        self.seat, self.intent = seat, Intent()
        self.lease = NO_LEASE
        self._outlets, self._acts = outlets, acts
        self._latencies, self._history = latencies, history
        self._shown = ShownViews(session)
        self._tasks: set[asyncio.Task[None]] = set()
        self._stopping = ThreadPoolExecutor(2, "stop")  # a stop never waits behind another request
        self._asking = ThreadPoolExecutor(2, "ask")

    def close(self) -> None:
        """Begin nothing more, and wait for what was asked: its link is closed, so that is soon."""
        for pool in (self._stopping, self._asking):
            pool.shutdown(cancel_futures=True)

    def tell_intent(self) -> None:
        """Tell the local site what the operating page wants; without one nothing is told, and so nothing is held."""
        now_ns = time.monotonic_ns()
        if self.seat.occupant is None or self._outlets is None:
            return
        intent = msgspec.structs.replace(self.intent, hold=self.seat.held(now_ns))
        self._outlets.intent(OperatorIntent(sent_ns=now_ns, intent=intent))

    def remember(self, view: str, frame: VideoFrame, now_ns: int, clock: ClockOffset | None) -> None:
        """A frame of the cell goes to the pages under this name of its view; `clock` is the remote one, if known."""
        self._shown.remember(view, frame, now_ns, clock.offset_ns if clock is not None else None)

    def hear(self, page: Page, said: AnyPageMessage, now_ns: int) -> None:
        """Do what a page says."""
        match said:
            case Beat():
                self.seat.beat(page.visitor, now_ns, down=said.down)
                page.letter(type="echo", page_ms=said.page_ms, server_ms=now_ns / NS_PER_MS)
            case FrameTaken():
                page.taken(said.view)
            case Ask():
                self._ask(page, said, now_ns)
            case AskLease():
                self._if_operating(page, said.id, lambda: self._acts.lease(said.action), f"lease: {said.action.value}")
            case MarkJoints():
                joints = said.shoulder, said.elbow, said.wrist
                self._if_operating(page, said.id, lambda: self._acts.joints(*joints), "joints")
            case TakeSeat():
                self._answer_seat(page, said.id, self.seat.take(page.visitor, now_ns), now_ns)
            case LeaveSeat():
                self._answer_seat(page, said.id, self.seat.leave(page.visitor), now_ns)
            case Shown() | Clutch() | Steer():
                if page.visitor == self.seat.occupant:
                    self._operate(said, now_ns)
            case _:
                assert_never(said)

    def _operate(self, said: Shown | Clutch | Steer, now_ns: int) -> None:
        match said:
            case Clutch():
                self.intent = msgspec.structs.replace(self.intent, clutch_count=self.intent.clutch_count + 1)
                self._history.note("operator", "new origins taken (clutch)", now_ns)
            case Steer():
                self.intent = said.apply(self.intent)
            case Shown():
                self._report(said, now_ns)
            case _:
                assert_never(said)

    def _report(self, said: Shown, now_ns: int) -> None:
        message = self._shown.message(said.views, self.lease, now_ns)
        if message is None:
            return
        for camera, view in message.views.items():
            self._latencies.painted(camera, view.capture_ns, view.age_ms, now_ns)
        if self._outlets is not None:
            self._outlets.shown(message)

    def _ask(self, page: Page, said: Ask, now_ns: int) -> None:
        if said.action is not EngagementAction.STOP:
            self._if_operating(page, said.id, lambda: self._acts.engagement(said.action), said.action.value)
            return
        self.seat.interrupt()
        self._history.note("stop", f"stop asked by {page.visitor}", now_ns)
        self._later(page, said.id, self._stopping, lambda: self._acts.engagement(said.action), "stop")

    def _if_operating(self, page: Page, number: int, act: Callable[[], Reply], what: str) -> None:
        if page.visitor == self.seat.occupant:
            self._later(page, number, self._asking, act, what)
            return
        who = f"{self.seat.occupant} operates" if self.seat.occupant is not None else "nobody operates"
        reason = f"this page only watches: {who}; take the controls first"
        page.letter(type="answer", id=number, what=what, done=False, code="watching", reason=reason, took_ms=0)

    def _answer_seat(self, page: Page, number: int, verdict: SeatAnswer, now_ns: int) -> None:
        if verdict.done:
            self._history.note("seat", f"{page.visitor}: {verdict.sentence}", now_ns)
        page.letter(
            type="answer",
            id=number,
            what="controls",
            done=verdict.done,
            code="seat",
            reason=verdict.sentence,
            took_ms=0,
        )

    def _later(self, page: Page, number: int, pool: ThreadPoolExecutor, act: Callable[[], Reply], what: str) -> None:
        """Ask in a thread that may wait, and answer the page when it is done."""
        asked_ns = time.monotonic_ns()

        async def ask() -> None:
            reply = await asyncio.get_running_loop().run_in_executor(pool, act)
            now_ns = time.monotonic_ns()
            took_ms = (now_ns - asked_ns) / NS_PER_MS
            outcome = f"done in {took_ms:.0f} ms" if reply.done else "refused"
            self._history.note(what, f"{what} {outcome}: {reply.reason}", now_ns)
            page.letter(
                type="answer",
                id=number,
                what=what,
                done=reply.done,
                code=reply.code,
                reason=reply.reason,
                took_ms=took_ms,
            )

        task = asyncio.get_running_loop().create_task(ask())
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

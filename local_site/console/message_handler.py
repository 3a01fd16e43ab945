"""Handles the pages' messages: who operates, the operator's intent, and requests to the sites."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, assert_never

from common.clock import NS_PER_MS, ClockOffset
from common.errors import MessageError
from common.messages.hand import Intent, OperatorIntent, OperatorSettings
from common.messages.recording import EpisodeOutcome
from common.messages.requests import EngagementAction, OperatorAction, PicturePoint, RecordAction, Reply
from common.messages.robot import Asker
from common.messages.video import VideoFrame, ViewsShown
from local_site.console.model.history import History
from local_site.console.model.late_reports import answered
from local_site.console.model.latency import Latencies
from local_site.console.model.leased_settings import LeasedSettings
from local_site.console.model.page_messages import (
    AnyPageMessage,
    Ask,
    AskLease,
    AskRecord,
    Beat,
    FrameLost,
    FrameTaken,
    LeaveSeat,
    MarkJoints,
    NewOrigins,
    Play,
    Shown,
    Steer,
    TakeSeat,
)
from local_site.console.model.seat import Seat, SeatAnswer
from local_site.console.model.shown import ShownViews
from local_site.console.page import Page
from local_site.console.request_pools import RequestPools, answer


class Requests(Protocol):
    """Asks the sites and waits for the answer."""

    def engagement(
        self, action: EngagementAction, seen_ns: int = 0, withdrawn: threading.Event | None = None, /
    ) -> Reply: ...

    def lease(self, action: OperatorAction, to: Asker | None) -> Reply: ...

    def record(self, action: RecordAction, outcome: EpisodeOutcome) -> Reply: ...

    def joints(self, shoulder: PicturePoint, elbow: PicturePoint, wrist: PicturePoint) -> Reply: ...


@dataclass(frozen=True, slots=True)
class Outlets:
    """The outlets for the operator's intent and for what is shown."""

    intent: Callable[[OperatorIntent], object]
    shown: Callable[[ViewsShown], object]


class PageMessageHandler:
    """Lives in the event loop; every method is called there. Any page may stop the arm, the rest is the operator's.

    Without outlets, where pages only watch, nothing is sent to the sites.
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
        self.seat = seat
        self._settings, self._late = LeasedSettings(), ""
        self._reported = False
        self._outlets, self._requests = outlets, requests
        self._latencies, self._history = latencies, history
        self._session, self._shown = session, ShownViews(session)
        self._pools = RequestPools(history, lambda: requests.engagement(EngagementAction.STOP))

    def close(self) -> None:
        """Begin nothing more, and wait for the requests under way: their link is closed, so it is short."""
        self._pools.close()

    @property
    def settings(self) -> OperatorSettings | None:
        """The settings in force at the remote site, or as the operating page has changed them; None if unknown."""
        return self._settings.newest

    def adopt(self, in_force: OperatorSettings | None, lease: int, late: str, now_ns: int) -> None:
        """Take the settings in force, unless the operating page has just changed them under the lease held here.

        `lease` is the number of the lease that this console's operator holds, `late` what is late of the operating
        page's reports, if any is.
        """
        self._late = late
        if self._settings.adopt(in_force, lease, now_ns):
            self._history.note("operator", "a change of scales or locks was not taken by the remote site", now_ns)

    def send_intent(self, now_ns: int) -> None:
        """Send the operating page's intent to the local site; once it is silent that is sent once, then nothing."""
        reports = self.seat.reports(now_ns)
        if self._outlets is not None and (reports or self._reported):
            intent = self._intent(now_ns) if reports else None
            self._outlets.intent(OperatorIntent(session=self._session, sent_ns=now_ns, intent=intent))
        self._reported = reports

    def _intent(self, now_ns: int) -> Intent:
        seat = self.seat
        return Intent(
            hold=seat.held(now_ns),
            settings=self._settings.own,
            assist=seat.assisted(now_ns),
            clutch=seat.clutch(now_ns),
        )

    def remember(self, view: str, frame: VideoFrame, now_ns: int, clock: ClockOffset | None, *, usable: bool) -> None:
        """A frame of the cell has gone to the pages under this name of its view, if any could decode it (`usable`).

        `clock` is the remote one, if known.
        """
        offset_ns = clock.offset_ns if clock is not None else None
        self._shown.remember(view, frame, now_ns, offset_ns, usable=usable)

    def handle(self, page: Page, message: AnyPageMessage, now_ns: int) -> None:
        """Carry out what a page asks for."""
        match message:
            case Beat():
                heard_ns = round(message.heard_ms * NS_PER_MS) if message.heard_ms is not None else None
                down, assist, clutch = message.down, message.assist, message.clutch
                self.seat.beat(page.visitor, now_ns, heard_ns, down=down, assist=assist, clutch=clutch)
                page.send(type="echo", page_ms=message.page_ms, server_ms=now_ns / NS_PER_MS)
            case FrameTaken():
                page.taken(message.view)
            case FrameLost():
                page.slots.interrupt(message.view)
            case Ask():
                self._ask(page, message, now_ns)
            case AskLease():
                to = message.to.asker if message.to is not None else None
                what = f"lease: {message.action.value}"
                self._if_operating(page, message.id, lambda: self._requests.lease(message.action, to), what)
            case AskRecord():
                what = f"recording: {message.action.value}"
                self._if_operating(
                    page, message.id, lambda: self._requests.record(message.action, message.outcome), what
                )
            case MarkJoints():
                joints = message.shoulder, message.elbow, message.wrist
                self._if_operating(page, message.id, lambda: self._requests.joints(*joints), "joints")
            case TakeSeat() | LeaveSeat():
                takes, visitor = isinstance(message, TakeSeat), page.visitor
                verdict = self.seat.take(visitor, now_ns) if takes else self.seat.leave(visitor)
                self._answer_seat(page, message.id, verdict, now_ns)
            case Shown() | NewOrigins() | Steer():
                if page.visitor == self.seat.occupant:
                    self._operate(message, now_ns)
            case Play():
                raise MessageError("invalid", "nothing is replayed here: the cell is live")
            case _:
                assert_never(message)

    def _operate(self, message: Shown | NewOrigins | Steer, now_ns: int) -> None:
        match message:
            case NewOrigins() | Steer():
                changed = self._settings.change(message, now_ns)
                if changed and isinstance(message, NewOrigins):
                    self._history.note("operator", "new origins taken", now_ns)
            case Shown():
                self._report(message, now_ns)
            case _:
                assert_never(message)

    def _report(self, message: Shown, now_ns: int) -> None:
        shown = self._shown.message(message, self._settings.lease, now_ns)
        if shown is None:
            return
        for camera, view in shown.views.items():
            self._latencies.painted(camera, view.capture_ns, view.age_ms, now_ns)
        if self._outlets is not None:
            self._outlets.shown(shown)

    def _ask(self, page: Page, message: Ask, now_ns: int) -> None:
        if message.action is not EngagementAction.STOP:
            self._if_operating(page, message.id, self._act(page, message), message.action.value)
            return
        self.seat.interrupt()
        self._history.stopper.ask(page.visitor, now_ns)
        self._history.note_once("stop", f"stop asked by {page.visitor}", now_ns)
        self._pools.stop(page, message.id)

    def _act(self, page: Page, message: Ask) -> Callable[[], Reply]:
        """Return what asks for an engagement or a reset until something withdraws it, or for the engagement's end."""
        action, seen_ns = message.action, int(message.seen)
        if action is not EngagementAction.DISENGAGE:
            standing = self._pools.standing
            return lambda: answered(self._requests.engagement(action, seen_ns, standing), self._late)
        if page.visitor == self.seat.occupant:
            self._pools.withdraw()
        return lambda: self._requests.engagement(action)

    def _if_operating(self, page: Page, number: int, act: Callable[[], Reply], what: str) -> None:
        if page.visitor == self.seat.occupant:
            self._pools.ask(page, number, act, what)
            return
        who = f"{self.seat.occupant} operates" if self.seat.occupant is not None else "nobody operates"
        reason = f"this page only watches: {who}; take the controls first"
        answer(page, number, what, Reply(id=number, done=False, code="watching", reason=reason))

    def _answer_seat(self, page: Page, number: int, verdict: SeatAnswer, now_ns: int) -> None:
        if verdict.done:
            self._history.note("seat", f"{page.visitor}: {verdict.sentence}", now_ns)
        answer(page, number, "controls", Reply(id=number, done=verdict.done, code="seat", reason=verdict.sentence))

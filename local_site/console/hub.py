"""The middle of the console: the newest messages of both sites go to every page."""

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import msgspec

from common.clock import ClockEstimate, ClockOffset
from common.messages.hand import HandArm
from common.messages.requests import Description
from common.messages.robot import RobotState
from common.messages.video import VideoFrame
from local_site.console.message_handler import NO_LEASE, PageMessageHandler
from local_site.console.model.frames import view_frame
from local_site.console.model.history import History
from local_site.console.model.latency import Latencies
from local_site.console.model.page_messages import parse
from local_site.console.model.shown import CAMERA_VIEW
from local_site.console.model.situation import NewestMessages, situation_json
from local_site.console.page import Page

OWN_CLOCK = ClockOffset(0, 0)


class CellClock(Protocol):
    """The current estimate of the remote clock, and how long its last question took."""

    round_trip_ms: float | None

    def estimate(self, now_ns: int) -> ClockEstimate | None: ...


class Hub:
    """Lives in the event loop; every method is called there. `watched` is called with whether any page is connected.

    `operator` is whose console this is; `operate` is whether a page may operate.
    """

    def __init__(
        self,
        handler: PageMessageHandler,
        watch: CellClock,
        latencies: Latencies,
        history: History,
        watched: Callable[[bool], None],
        operator: str,
        *,
        operate: bool,
    ) -> None:
        self._handler, self._watch = handler, watch
        self._latencies, self._history = latencies, history
        self._operate, self._operator, self._watched = operate, operator, watched
        self._newest = NewestMessages()
        self._cell: Description | None = None
        self._pages: list[Page] = []

    def arrive(self, page: Page) -> None:
        """A page has connected."""
        now_ns = time.monotonic_ns()
        self._pages.append(page)
        self._watched(True)
        self._handler.seat.arrive(page.visitor, now_ns)
        page.send(type="hello", page=page.visitor.number, operate=self._operate, operator=self._operator)
        if self._cell is not None:
            self._introduce(page, self._cell)

    def leave(self, page: Page) -> None:
        """A page has gone."""
        self._pages.remove(page)
        self._watched(bool(self._pages))
        if page.visitor == self._handler.seat.occupant:
            self._handler.seat.leave(page.visitor)
            self._history.note("seat", f"{page.visitor} is gone, nobody operates", time.monotonic_ns())

    def receive(self, page: Page, text: str) -> None:
        """A message has come from a page; MessageError when it is none that is known."""
        self._handler.handle(page, parse(text), time.monotonic_ns())

    def state(self, state: RobotState) -> None:
        """The robot's state has come."""
        now_ns = time.monotonic_ns()
        self._newest = replace(self._newest, state=state, state_ns=now_ns)
        lease = state.lease
        self._handler.lease = lease.number if lease is not None and lease.holder == self._operator else NO_LEASE
        self._history.add_state(state, now_ns)
        self._latencies.add_state(state, now_ns)

    def hand(self, hand: HandArm) -> None:
        """A hand sample has come."""
        self._newest = replace(self._newest, hand=hand, hand_ns=time.monotonic_ns())

    def camera(self, frame: VideoFrame) -> None:
        """A picture of the cell has come."""
        now_ns = time.monotonic_ns()
        known = self._watch.estimate(now_ns)
        view, clock = CAMERA_VIEW + frame.camera, known.offset if known is not None else None
        self._handler.remember(view, frame, now_ns, clock)
        self._show(view, frame, clock)

    def preview(self, frame: VideoFrame) -> None:
        """A picture of the operator has come, by this host's clock."""
        self._show(f"preview/{frame.camera}", frame, OWN_CLOCK)

    def described(self, cell: Description) -> None:
        """The description of the cell has come."""
        self._cell = cell
        for page in self._pages:
            self._introduce(page, cell)

    def refused(self, sentence: str) -> None:
        """The cell is refused, as one of another release."""
        self._history.note_change("refused", "fault", sentence, time.monotonic_ns())

    def send_situation(self) -> None:
        """Send the situation to every page."""
        now_ns = time.monotonic_ns()
        clock = self._watch.estimate(now_ns), self._watch.round_trip_ms
        self._latencies.add_clock(*clock, now_ns)
        if not self._pages:
            return
        seat, intent = self._handler.seat, self._handler.intent
        situation = situation_json(now_ns, self._newest, *clock, seat, intent, self._latencies, self._history)
        for page in self._pages:
            page.situation(situation)

    def _introduce(self, page: Page, cell: Description) -> None:
        page.send(type="cell", cell=msgspec.to_builtins(cell))

    def _show(self, view: str, frame: VideoFrame, clock: ClockOffset | None) -> None:
        if not self._pages:
            return
        outgoing = view_frame(view, frame, clock)
        for page in self._pages:
            page.frame(outgoing)

"""The middle of the console: the newest messages of both sites go to every page."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, Protocol

import msgspec

from common.clock import ClockEstimate, ClockOffset
from common.host_clock import MonotonicClock
from common.messages.hand import HandArm, OperatorSettings
from common.messages.recording import RecordingNotice
from common.messages.requests import Description
from common.messages.robot import RobotState
from common.messages.video import VideoFrame
from local_site.console.key_frames import KeyFrames
from local_site.console.model.frames import view_frame
from local_site.console.model.history import History
from local_site.console.model.late_reports import late_reports, named
from local_site.console.model.latency import Latencies
from local_site.console.model.leased_settings import NO_LEASE
from local_site.console.model.page_messages import AnyPageMessage, parse
from local_site.console.model.seat import Seat
from local_site.console.model.sent_target import SentTarget, tools_json
from local_site.console.model.shown import CAMERA_VIEW
from local_site.console.model.situation import NewestMessages, situation_json
from local_site.console.page import OpenPages, Page

OWN_CLOCK = ClockOffset(0, 0)
HOST_CLOCK = MonotonicClock()


class CellClock(Protocol):
    """The current estimate of the remote clock, and how long its last question took."""

    round_trip_ms: float | None

    def estimate(self, now_ns: int) -> ClockEstimate | None: ...


class PageHandler(Protocol):
    """Handler of the pages' messages: that of a live cell, or that of a replay."""

    seat: Seat

    @property
    def settings(self) -> OperatorSettings | None: ...

    def adopt(self, in_force: OperatorSettings | None, lease: int, late: str, now_ns: int) -> None: ...

    def remember(
        self, view: str, frame: VideoFrame, now_ns: int, clock: ClockOffset | None, *, usable: bool
    ) -> None: ...

    def handle(self, page: Page, message: AnyPageMessage, now_ns: int) -> None: ...


class NowClock(Protocol):
    """The time that pages live in: this host's, or a recording's."""

    def now_ns(self) -> int: ...


class Hub:
    """Lives in the event loop; every method is called there. `watched` is called with whether any page is connected.

    `operator` is whose console this is; `operate` is whether a page may operate; `remote` is where the remote site is
    looked for. `replay` describes the recording to the pages where it is not the cell that they see.
    """

    def __init__(
        self,
        handler: PageHandler,
        watch: CellClock,
        latencies: Latencies,
        history: History,
        watched: Callable[[bool], None],
        key_frames: KeyFrames,
        operator: str,
        *,
        operate: bool,
        remote: str = "",
        clock: NowClock = HOST_CLOCK,
        replay: Mapping[str, Any] | None = None,
    ) -> None:
        self._handler, self._watch, self._clock = handler, watch, clock
        self._latencies, self._history = latencies, history
        self._hello = {"operate": operate, "operator": operator, "remote": remote, "replay": replay}
        self._key_frames = key_frames
        self._newest = NewestMessages()
        self._sent = SentTarget()
        self._cell: Description | None = None
        self._pages = OpenPages(watched)

    def arrive(self, page: Page) -> None:
        """A page has connected."""
        now_ns = self._clock.now_ns()
        self._pages.add(page)
        self._handler.seat.arrive(page.visitor, now_ns)
        page.send(type="hello", page=page.visitor.number, **self._hello)
        if self._cell is not None:
            self._introduce(page, self._cell)

    def leave(self, page: Page) -> None:
        """A page has gone."""
        self._pages.remove(page)
        if page.visitor == self._handler.seat.occupant:
            self._handler.seat.go(page.visitor)
            self._history.note("seat", f"{page.visitor} is gone, nobody operates", self._clock.now_ns())

    def receive(self, page: Page, text: str) -> None:
        """A message has come from a page; MessageError when it is none that is known."""
        self._handler.handle(page, parse(text), self._clock.now_ns())

    def state(self, state: RobotState) -> None:
        """The robot's state has come."""
        now_ns, held, newest = self._clock.now_ns(), state.lease, self._newest
        lease = held.number if held is not None and held.holder == self._hello["operator"] else NO_LEASE
        hand_ns = newest.hand_ns if newest.hand is not None else None
        late = late_reports(self._handler.seat, hand_ns, state, now_ns) if lease != NO_LEASE else ""
        state = named(state, late)
        self._newest = replace(newest, state=state, state_ns=now_ns)
        self._handler.adopt(state.settings, lease, late, now_ns)
        self._sent.add_state(state)
        self._history.add_state(state, now_ns)
        self._latencies.add_state(state, now_ns)

    def hand(self, hand: HandArm) -> None:
        """A hand sample has come."""
        self._newest = replace(self._newest, hand=hand, hand_ns=self._clock.now_ns())
        self._sent.add_hand(hand)

    def recording(self, notice: RecordingNotice) -> None:
        """The recorder of the operator's side has reported what it does."""
        self._newest = replace(self._newest, notice=notice, notice_ns=self._clock.now_ns())

    def camera(self, frame: VideoFrame) -> None:
        """A picture of the cell has come."""
        now_ns = self._clock.now_ns()
        known = self._watch.estimate(now_ns)
        view, clock = CAMERA_VIEW + frame.camera, known.of_stamp(frame.ahead_ns) if known is not None else None
        usable = self._show(view, frame, clock)
        self._handler.remember(view, frame, now_ns, clock, usable=usable)
        wanted = [after for page in self._pages if (after := page.slots.wants_after(view)) is not None]
        if wanted:
            self._key_frames.ask(frame.camera, max(wanted), now_ns)

    def preview(self, frame: VideoFrame) -> None:
        """A picture of the operator has come, by this host's clock."""
        self._show(f"preview/{frame.camera}", frame, OWN_CLOCK)

    def described(self, cell: Description) -> None:
        """The description of the cell has come."""
        self._cell = cell
        for page in self._pages:
            self._introduce(page, cell)
        self._sent.describe(cell)

    def refused(self, sentence: str) -> None:
        """The cell is refused, as one of another release."""
        self._history.note_change("refused", "fault", sentence, self._clock.now_ns())

    def send_situation(self) -> None:
        """Send every page the situation, and before it the tools: together, so that the browser draws both at once."""
        now_ns = self._clock.now_ns()
        clock = self._watch.estimate(now_ns), self._watch.round_trip_ms
        self._latencies.add_clock(*clock, now_ns)
        if self._newest.state is not None:
            self._history.watch_silence(self._newest.state_ns, now_ns)
        if not self._pages:
            return
        seat, settings = self._handler.seat, self._handler.settings
        situation = situation_json(now_ns, self._newest, *clock, seat, settings, self._latencies, self._history)
        tools = self._tools(now_ns)
        for page in self._pages:
            page.newest("tools", tools)
            page.newest("situation", situation)

    def tell(self, kind: str, text: str) -> None:
        """Send every page the newest of another kind, as JSON."""
        for page in self._pages:
            page.newest(kind, text)

    def begin_again(self, latencies: Latencies, history: History) -> None:
        """Forget what has come: the time has jumped."""
        self._newest, self._sent = NewestMessages(), SentTarget()
        self._latencies, self._history = latencies, history
        if self._cell is not None:
            self._sent.describe(self._cell)

    def _tools(self, now_ns: int) -> str:
        """Where the tool is, and where it has been sent."""
        known = self._watch.estimate(now_ns)
        remote = known.offset if known is not None else None
        sent = self._sent.base_T_tool(now_ns, remote)
        return tools_json(self._newest.state, self._newest.hand, sent, self._sent.wanted, remote)

    def _introduce(self, page: Page, cell: Description) -> None:
        page.send(type="cell", cell=msgspec.to_builtins(cell))

    def _show(self, view: str, frame: VideoFrame, clock: ClockOffset | None) -> bool:
        """Send a picture to all pages; return whether any of them can decode it."""
        if not self._pages:
            return False
        outgoing = view_frame(view, frame, clock)
        return sum(page.frame(outgoing) for page in self._pages) > 0

"""Events as sentences with their times, newest first; whose stop stands, and which fault nobody has answered."""

from collections import deque
from dataclasses import dataclass

from common.clock import NS_PER_S
from common.link.channels import STATE
from common.messages.robot import SITE_ENDED, STOPPED, RobotState, SessionState
from local_site.console.model.seat import Visitor

KEPT = 30
TROUBLE_NS = 3 * NS_PER_S  # near a limit trouble comes and goes
SHIFT_MM, SHIFT_DEG = 1.0, 1.0  # a smaller shift of the reference is not noted
REPEAT_NS = 3 * NS_PER_S  # a page asks for a stop each second until it is acknowledged: that is one event
QUIET_NS = NS_PER_S  # at most one change of the code a second: while engaged it may change at every tick
ASKED_WITHIN_NS = 2 * NS_PER_S  # a page asks each second until the remote site has acknowledged it


class UnansweredFault:
    """Keeps the fault or stop of a remote site that was started again before a reset; the new one knows nothing of it.

    A reset answers it, and so does an engagement of the new site.
    """

    def __init__(self) -> None:
        self._session: int | None = None
        self._reason = ""
        self.reason: str | None = None

    def see(self, state: RobotState) -> None:
        """Take the newest state; `reason` is then the former site's sentence, None where none is left to answer."""
        if state.code == SITE_ENDED:
            return
        if state.state is SessionState.FAULT or state.code == STOPPED:
            self._session, self._reason, self.reason = state.session, state.reason, None
        elif self._session not in (None, state.session) and state.state is SessionState.DISENGAGED:
            self.reason = self._reason
        else:
            self._session = self.reason = None


class Stopper:
    """Takes the pages' stops and the remote site's states; `page` is whose stop stands, None if nobody's here."""

    def __init__(self) -> None:
        self.page: Visitor | None = None
        self._asked_by: Visitor | None = None
        self._asked_ns = 0

    def ask(self, page: Visitor, now_ns: int) -> None:
        """A page asks for a stop."""
        self._asked_by, self._asked_ns = page, now_ns

    def see(self, state: RobotState, now_ns: int) -> None:
        """Take the newest state."""
        if state.state is not SessionState.FAULT and state.readiness.code != STOPPED:
            self.page = None
        elif self._asked_by is not None and now_ns - self._asked_ns <= ASKED_WITHIN_NS:
            self.page = self._asked_by


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened: its number, its time by the console's clock in ns, its kind, and what it was."""

    number: int
    t_ns: int
    kind: str
    text: str


class History:
    """Keeps the last events; a repetition is not noted. `unanswered` is the fault or stop in which a site has ended,
    `stopper` the page whose stop stands.
    """

    def __init__(self) -> None:
        self.events: deque[Event] = deque(maxlen=KEPT)
        self._count = 0
        self._last: dict[str, str] = {}
        self._noted_ns = 0
        self._trouble_ns: dict[str, int] = {}
        self._said_ns: dict[str, int] = {}
        self._silent_since_ns: int | None = None
        self.unanswered = UnansweredFault()
        self.stopper = Stopper()

    def note(self, kind: str, text: str, now_ns: int) -> None:
        """Note an event."""
        self._count += 1
        self.events.appendleft(Event(self._count, now_ns, kind, text))

    def note_change(self, topic: str, kind: str, text: str, now_ns: int) -> None:
        """Note the state of a topic, if it has changed."""
        if self._last.get(topic) != text:
            self._last[topic] = text
            self.note(kind, text, now_ns)

    def note_once(self, kind: str, text: str, now_ns: int) -> None:
        """Note an event, unless it is only said again."""
        last_ns = self._said_ns.get(text)
        self._said_ns = {said: t_ns for said, t_ns in self._said_ns.items() if now_ns - t_ns < REPEAT_NS}
        self._said_ns[text] = now_ns
        if last_ns is None or now_ns - last_ns >= REPEAT_NS:
            self.note(kind, text, now_ns)

    def watch_silence(self, heard_ns: int, now_ns: int) -> None:
        """Note that the remote site has fallen silent, last heard at `heard_ns`, and that it answers again."""
        is_silent = now_ns - heard_ns > STATE.stale_after_ns
        if is_silent and self._silent_since_ns is None:
            self._silent_since_ns = heard_ns
            self.note("fault", "the remote site has fallen silent", now_ns)
        elif not is_silent and self._silent_since_ns is not None:
            silent_s = (now_ns - self._silent_since_ns) / NS_PER_S
            self._silent_since_ns = None
            self.note("link", f"the remote site answers again after {silent_s:.1f} s", now_ns)

    def add_state(self, state: RobotState, now_ns: int) -> None:
        """Note a change of state, of its code or who stopped it, of the links' trouble, or of who holds the lease."""
        self.unanswered.see(state)
        self.stopper.see(state, now_ns)
        self._note_session(state, now_ns)
        self._note_links(state, now_ns)
        self._note_limit(state, now_ns)
        self._note_reference(state, now_ns)
        holder = f"{state.lease} holds the lease" if state.lease is not None else "nobody holds the lease"
        self.note_change("lease", "lease", holder, now_ns)
        if state.lease is not None and state.lease.asked_by is not None:
            self.note_change("asked", "lease", f"{state.lease.asked_by} asks for the lease", now_ns)

    def _note_links(self, state: RobotState, now_ns: int) -> None:
        """Note trouble of a link once it begins or changes; its figures change all the time."""
        hand, video = state.hand_link, state.video_link
        found = {"hand's link": (hand.code, hand.reason)} if hand is not None else {}
        found["pictures' way"] = (video.code, video.reason) if video is not None else ("", "")
        for topic, (code, reason) in found.items():
            if code != self._last.get(topic, "") and now_ns - self._trouble_ns.get(topic, -TROUBLE_NS) >= TROUBLE_NS:
                self._last[topic], self._trouble_ns[topic] = code, now_ns
                self.note("link", reason or f"the {topic} is good again", now_ns)

    def _note_limit(self, state: RobotState, now_ns: int) -> None:
        """Note that samples of another age are obeyed, and how fast the arm may be in return."""
        limit = (
            f"hand samples up to {state.age_limit_ms:.0f} ms old are obeyed, at {state.speed_scale:.0%} of the speed"
        )
        first = "age limit" not in self._last
        if self._last.get("age limit") != limit:
            self._last["age limit"] = limit
            if not first:
                self.note("link", limit, now_ns)

    def _note_reference(self, state: RobotState, now_ns: int) -> None:
        """Note that new origins after a hold have moved the reference."""
        engagement = state.engagement
        if engagement is None or (engagement.shift_mm < SHIFT_MM and engagement.shift_deg < SHIFT_DEG):
            return
        captured = str(engagement.hand_capture_ns)
        if self._last.get("reference") != captured:
            self._last["reference"] = captured
            moved = f"{engagement.shift_mm:.0f} mm and {engagement.shift_deg:.0f} deg"
            self.note("link", f"the reference has moved by {moved}: the hand's way during the hold is lost", now_ns)

    def _note_session(self, state: RobotState, now_ns: int) -> None:
        is_barred = state.code == STOPPED or state.state is SessionState.FAULT
        why = state.reason if is_barred else state.code  # a stop behind another one changes the reason alone
        same_state = self._last.get("state") == state.state.value
        if same_state and (self._last.get("why") == why or now_ns - self._noted_ns < QUIET_NS):
            return
        self._last |= {"state": state.state.value, "why": why}
        self._noted_ns = now_ns
        word = state.state.value
        self.note(word, state.reason if state.reason.startswith(word) else f"{word}: {state.reason}", now_ns)

"""Sends probes over a link of its own and collects their echoes; moves nothing and needs no lease."""

import secrets
import time
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

from common.clock import NS_PER_MS, NS_PER_S, Clock
from common.errors import TransportError
from common.host_clock import MonotonicClock
from common.link.channel_feeds import ChannelFeeds
from common.link.channels import ECHO, LOAD, LOAD_ECHO, PROBE, STATE
from common.link.config import LinkSecurity
from common.link.pubsub import Publisher
from common.link.transport import Link, open_link
from common.messages.base import SESSION_BITS
from common.messages.probe import MOST_PADDING, Probe, ProbeEcho
from common.messages.robot import FOLLOWING, RobotState
from farhand.doctor.link.figures import Echoed, LinkFigures, link_figures, round_trips_ms

HAND_BYTES = 600  # of a hand sample
FIRST_ECHO_S, ASK_EVERY_S = 5.0, 0.1
STRAGGLERS_S = 1.0
LOAD_POLL_S = 0.001
LEAST_ECHOES = 10
FIRST_BYTES, MOST_BYTES = 1 << 16, 1 << 21
LEAST_ROUND_NS = 50 * NS_PER_MS  # beyond a round trip, so that there is load to judge
QUEUED_NS = 100 * NS_PER_MS  # what takes longer than a round trip by this has waited: the link is full
LOST_NS = 3 * NS_PER_S


class LoadWindow:
    """Grows twofold as long as the quickest load since it last grew has waited little; times in ns of one clock."""

    def __init__(self, round_trip_ns: int, now_ns: int) -> None:
        self._round_trip_ns = round_trip_ns
        self._window = FIRST_BYTES
        self._sent: dict[int, tuple[int, int]] = {}  # number: when, and how many bytes
        self._arrived: list[tuple[int, int]] = []
        self._grown_ns, self._least_age_ns = now_ns, LOST_NS

    def has_room(self, now_ns: int) -> bool:
        """Return whether more may be sent now."""
        return self.on_its_way(now_ns) < self._window

    def on_its_way(self, now_ns: int) -> int:
        """The bytes that have not arrived; what has not come for LOST_NS counts as lost."""
        self._sent = {number: sent for number, sent in self._sent.items() if now_ns - sent[0] < LOST_NS}
        return sum(size for _, size in self._sent.values())

    def sent(self, number: int, size: int, now_ns: int) -> None:
        """Load of this number and size in bytes was sent."""
        self._sent[number] = now_ns, size

    def arrived(self, number: int, now_ns: int) -> None:
        """It has arrived, as an echo reports."""
        if number not in self._sent:
            return
        sent_ns, size = self._sent.pop(number)
        self._arrived.append((now_ns, size))
        if sent_ns < self._grown_ns + self._round_trip_ns // 2:
            return  # the queue was still that of the smaller window
        self._least_age_ns = min(self._least_age_ns, now_ns - sent_ns)
        if now_ns - self._grown_ns >= self._round_trip_ns + LEAST_ROUND_NS:
            if self._least_age_ns < self._round_trip_ns + QUEUED_NS:
                self._window = min(2 * self._window, MOST_BYTES)
            self._grown_ns, self._least_age_ns = now_ns, LOST_NS

    def mbit_s(self) -> float:
        """Compute the rate, Mbit/s, in the later half of the time in which anything arrived; 0 where hardly any did."""
        if not self._arrived:
            return 0.0
        first_ns, last_ns = self._arrived[0][0], self._arrived[-1][0]
        middle_ns = (first_ns + last_ns) // 2
        counted = sum(size for t_ns, size in self._arrived if t_ns > middle_ns)
        return counted * 8e3 / (last_ns - middle_ns) if last_ns > middle_ns else 0.0


@dataclass(frozen=True, slots=True)
class ProbePlan:
    """The duration and rate of probes; while the arm is engaged, at the rate of hand samples, without load."""

    seconds: float = 10.0
    hz: float = 30.0
    engaged_hz: float = 30.0
    load_seconds: float = 4.0


@dataclass
class HeardProbes:
    """The messages that came over the link, with the time of arrival (ns)."""

    echoes: list[tuple[ProbeEcho, int]] = field(default_factory=list)
    loads: list[tuple[ProbeEcho, int]] = field(default_factory=list)
    state: RobotState | None = None

    def take_state(self, state: RobotState, _now_ns: int) -> None:
        """The robot's state has come."""
        self.state = state

    @property
    def engaged(self) -> bool:
        """Return whether the arm follows, or would follow again."""
        return self.state is not None and self.state.state in FOLLOWING


def measure_link(
    endpoint: str, security: LinkSecurity, cell: str, operator: str, plan: ProbePlan | None = None
) -> LinkFigures:
    """Measure the link at one endpoint; TransportError with the reason where no echo comes, RefusedError as a link."""
    with ExitStack() as stack:
        feeds = ChannelFeeds()
        stack.callback(feeds.join)  # once the link is closed
        link = stack.enter_context(open_link(connect=(endpoint,), security=security))
        prober = LinkProber(link, endpoint, cell, operator, MonotonicClock(), feeds)
        return prober.measure(plan or ProbePlan())


class LinkProber:
    """Probes one open link as an operator."""

    def __init__(self, link: Link, endpoint: str, cell: str, operator: str, clock: Clock, feeds: ChannelFeeds) -> None:
        self._link, self._endpoint, self._clock, self._heard = link, endpoint, clock, HeardProbes()
        self._probes = link.publisher(PROBE, cell, operator=operator)
        self._loads = link.publisher(LOAD, cell, operator=operator)
        heard = self._heard
        echoes = link.latest(ECHO, cell, operator=operator)
        load_echoes = link.latest(LOAD_ECHO, cell, operator=operator)
        states = link.latest(STATE, cell)
        feeds.add(echoes, lambda echo, now_ns: heard.echoes.append((echo, now_ns)))
        feeds.add(load_echoes, lambda echo, now_ns: heard.loads.append((echo, now_ns)))
        feeds.add(states, heard.take_state)

    def measure(self, plan: ProbePlan) -> LinkFigures:
        """Round trips, jitter and loss, then what the link carries both ways, unless the arm is engaged."""
        self._await_echo()
        sent, echoes = self._sequence(plan)
        if len(echoes) < LEAST_ECHOES:
            raise TransportError(f"{self._endpoint} answers {len(echoes)} of {sent} probes: the link loses nearly all")
        figures = link_figures(self._endpoint, sent, echoes)
        round_trip_ns = round(min(round_trips_ms(echoes)) * 1e6)
        there = self._carried(plan.load_seconds, round_trip_ns, there=True)
        back = self._carried(plan.load_seconds, round_trip_ns, there=False)
        heard = self._heard
        return replace(
            figures,
            there=replace(figures.there, mbit_s=there),
            back=replace(figures.back, mbit_s=back),
            engaged=heard.engaged,
            hand=heard.state.hand_link if heard.state is not None else None,
        )

    def _await_echo(self) -> None:
        session, deadline_s = secrets.randbits(SESSION_BITS), time.monotonic() + FIRST_ECHO_S
        seq = 0
        while not self._heard.echoes:
            if time.monotonic() > deadline_s:
                self._link.check_connected()
                why = self._link.why_silent() or "is the remote site running, and of this release?"
                raise TransportError(f"{self._endpoint} does not answer: {why}")
            self._probes.put(Probe(session=session, seq=seq, sent_ns=self._clock.now_ns()))
            seq += 1
            time.sleep(ASK_EVERY_S)
            if seq % 10 == 0:
                self._link.check_connected()

    def _sequence(self, plan: ProbePlan) -> tuple[int, list[Echoed]]:
        """A sequence of probes of a hand sample's size; how many were sent, and the echoes that came."""
        session, clock = secrets.randbits(SESSION_BITS), self._clock
        hz = plan.engaged_hz if self._heard.engaged else plan.hz
        count, begin_ns = round(plan.seconds * hz), clock.now_ns()
        for seq in range(count):
            clock.sleep_until_ns(begin_ns + round(seq * NS_PER_S / hz))
            sent_ns, size = clock.now_ns(), HAND_BYTES
            self._probes.put(Probe(session=session, seq=seq, sent_ns=sent_ns, echo_bytes=size, padding=bytes(size)))
        deadline_ns = clock.now_ns() + round(STRAGGLERS_S * NS_PER_S)
        while clock.now_ns() < deadline_ns and len(self._of(session)) < count:
            time.sleep(ASK_EVERY_S)
        return count, [
            Echoed(e.seq, e.sent_ns, e.received_ns, e.answered_ns, now_ns, e.received)
            for e, now_ns in self._of(session)
        ]

    def _of(self, session: int) -> list[tuple[ProbeEcho, int]]:
        return [heard for heard in list(self._heard.echoes) if heard[0].session == session]

    def _carried(self, seconds: float, round_trip_ns: int, *, there: bool) -> float | None:
        """Measure what the link carries one way, Mbit/s; None while the arm is engaged."""
        session, clock, loads = secrets.randbits(SESSION_BITS), self._clock, self._heard.loads
        begin_ns = clock.now_ns()
        window, end_ns, seq, taken = LoadWindow(round_trip_ns, begin_ns), begin_ns + round(seconds * NS_PER_S), 0, 0
        loads.clear()
        while clock.now_ns() < end_ns or window.on_its_way(clock.now_ns()):
            if self._heard.engaged or any(echo.refused for echo, _ in loads[-1:]):
                return None
            for echo, arrived_ns in loads[taken:]:
                taken += 1
                if echo.session == session:
                    window.arrived(echo.seq, arrived_ns)
            now_ns = clock.now_ns()
            if now_ns >= end_ns or not window.has_room(now_ns):
                time.sleep(LOAD_POLL_S)
                continue
            _put_load(self._loads, session, seq, now_ns, there=there)
            window.sent(seq, MOST_PADDING, now_ns)
            seq += 1
        return window.mbit_s()


def _put_load(loads: Publisher[Probe], session: int, seq: int, now_ns: int, *, there: bool) -> None:
    """Load one way: padding there, or padding asked back."""
    padding, asked = (bytes(MOST_PADDING), 0) if there else (b"", MOST_PADDING)
    loads.put(Probe(session=session, seq=seq, sent_ns=now_ns, echo_bytes=asked, padding=padding))

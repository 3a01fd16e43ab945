"""The probe server: every probe echoed once and counted, little work a tick, no load while the arm is engaged."""

from collections import deque
from dataclasses import dataclass, field
from typing import Any

from common.clock import FakeClock
from common.errors import MessageError
from common.link.channels import ECHO, LOAD, LOAD_ECHO, PROBE
from common.messages.codec import encode
from common.messages.probe import Probe, ProbeEcho
from remote_site.runtime.probe_server import PER_TICK, ProbeServer


@dataclass
class FakeLink:
    """A link on which probes wait by channel and operator, and echoes are kept."""

    waiting: dict[tuple[str, str], deque[Probe | MessageError]] = field(default_factory=dict)
    echoes: list[tuple[str, str, ProbeEcho]] = field(default_factory=list)

    def latest(self, channel, _cell, *, operator):
        return FakeSource(operator, self.waiting.setdefault((channel.key, operator), deque()))

    def publisher(self, channel, _cell, *, operator):
        return FakePublisher(lambda echo: self.echoes.append((channel.key, operator, echo)))


@dataclass
class FakeSource:
    operator: str
    waiting: deque[Probe | MessageError]

    def take_named(self):
        if not self.waiting:
            return None
        probe = self.waiting.popleft()
        if isinstance(probe, MessageError):
            raise probe
        return self.operator, probe


@dataclass
class FakePublisher:
    put: object


def probes(count, session=5, echo_bytes=0):
    return deque(Probe(session=session, seq=seq, sent_ns=seq, echo_bytes=echo_bytes) for seq in range(count))


def server(link, refused=print, operators=("anna", "ben")):
    return ProbeServer(link, "lab", operators, FakeClock(100), refused)


def test_every_probe_is_echoed_with_how_many_have_come():
    link = FakeLink()
    serving = server(link)
    link.waiting[PROBE.key, "anna"].extend(probes(4, echo_bytes=600))
    for _ in range(4):
        serving.poll(engaged=False)
    assert [(key, who) for key, who, _ in link.echoes] == [(ECHO.key, "anna")] * 4
    assert [(e.seq, e.received, len(e.padding)) for *_, e in link.echoes] == [(k, k + 1, 600) for k in range(4)]
    link.waiting[PROBE.key, "anna"].extend(probes(1, session=6))
    serving.poll(engaged=False)
    assert link.echoes[-1][2].received == 1


def test_a_tick_echoes_few_and_no_operator_waits_for_another():
    link = FakeLink()
    serving = server(link)
    for who in ("anna", "ben"):
        link.waiting[PROBE.key, who].extend(probes(50))
    for tick in range(1, 5):
        serving.poll(engaged=False)
        assert len(link.echoes) == tick * PER_TICK
    assert {who for _, who, _ in link.echoes} == {"anna", "ben"}


def test_an_engaged_arms_link_is_not_loaded_but_still_probed():
    link = FakeLink()
    serving = server(link)
    link.waiting[LOAD.key, "anna"].extend(probes(1, echo_bytes=16_000))
    link.waiting[PROBE.key, "anna"].extend(probes(1, echo_bytes=600))
    serving.poll(engaged=True)
    found = {key: (echo.refused, len(echo.padding)) for key, _, echo in link.echoes}
    assert found == {LOAD_ECHO.key: (True, 0), ECHO.key: (False, 600)}
    link.waiting[LOAD.key, "anna"].extend(probes(1, echo_bytes=16_000))
    serving.poll(engaged=False)
    assert (link.echoes[-1][2].refused, len(link.echoes[-1][2].padding)) == (False, 16_000)


def test_no_probe_is_a_load_under_another_name():
    link = FakeLink()
    link.waiting[PROBE.key, "anna"] = probes(1, echo_bytes=16_000)
    server(link).poll(engaged=True)
    ((_, _, echo),) = link.echoes
    assert len(encode(echo)) <= ECHO.max_bytes


def test_what_is_no_probe_is_reported_and_counts_as_work():
    link, refused = FakeLink(), list[Any]()
    serving = server(link, refused.append)
    link.waiting[PROBE.key, "anna"].extend([MessageError("malformed", "no map")] * 3)
    serving.poll(engaged=False)
    assert len(refused) == PER_TICK
    assert link.echoes == []

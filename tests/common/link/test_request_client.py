"""Requests on a clock moved by hand: when they are sent, sent again and given up."""

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, cast

import pytest

from common.clock import NS_PER_MS, NS_PER_S, ClockEstimate, ClockOffset, FakeClock
from common.errors import TransportError
from common.link.channels import ENGAGEMENT, STOP, Procedure
from common.link.engagement_client import ask_engagement
from common.link.remote_clock import RemoteClock
from common.link.request_client import ATTEMPT_NS, PATIENCE_NS, RequestClient, RequestSchedule
from common.link.transport import REQUEST_TIMEOUT_S, Link
from common.messages.requests import EngagementAction, EngagementRequest, Reply, StopRequest

ENGAGE = partial(EngagementRequest, action=EngagementAction.ENGAGE)
OFFSET_NS = 3600 * NS_PER_S

Answering = Callable[[EngagementRequest, int], Reply | None]


def reply(code: str) -> Reply:
    return Reply(id=1, done=code == "ok", code=code, reason="")


class FakeLink:
    """Answers as configured, immediately; records when each request came and what it was."""

    def __init__(self, clock: FakeClock, answering: Answering) -> None:
        self._clock, self._answering = clock, answering
        self.asked: list[tuple[int, EngagementRequest]] = []

    def ask(
        self, procedure: Procedure[Any, Any], cell: str, question: EngagementRequest, *, operator: str, timeout_s: float
    ) -> Reply | None:
        assert (procedure, cell, operator) == (ENGAGEMENT, "lab", "anna")
        left_s = (question.deadline_ns % OFFSET_NS - self._clock.time_ns) / NS_PER_S
        assert timeout_s == min(REQUEST_TIMEOUT_S, left_s), "it does not wait beyond the deadline"
        self.asked.append((self._clock.time_ns, question))
        return self._answering(question, len(self.asked))


class FakeRemoteClock:
    """Known from a measurement on, which succeeds at the given attempt."""

    def __init__(self, succeeds_at: int) -> None:
        self._succeeds_at, self._attempts = succeeds_at, 0

    def measure(self) -> object | None:
        self._attempts += 1
        return self if self._attempts >= self._succeeds_at else None

    def estimate(self, now_ns: int) -> ClockEstimate | None:
        known = self._attempts >= self._succeeds_at
        return ClockEstimate(ClockOffset(OFFSET_NS, 1), now_ns) if known else None


def asked(answering: Answering, remote_clock: FakeRemoteClock | None = None) -> tuple[Reply | None, FakeLink]:
    """The reply, None when the request was given up at its deadline, and the link that was asked."""
    clock = FakeClock()
    link = FakeLink(clock, answering)
    client = RequestClient(
        cast(Link, link), "lab", cast("RemoteClock | None", remote_clock), operator="anna", clock=clock
    )
    answer = None
    try:
        answer = client.ask(ENGAGEMENT, ENGAGE)
    except TransportError:
        assert clock.time_ns == PATIENCE_NS
    return answer, link


def test_a_request_is_asked_again_with_its_id_and_deadline_until_it_is_answered() -> None:
    answer, link = asked(lambda _, attempt: reply("ok") if attempt == 3 else None)
    assert answer == reply("ok")
    assert [at_ns for at_ns, _ in link.asked] == [0, ATTEMPT_NS, 2 * ATTEMPT_NS]
    assert len({request.id for _, request in link.asked}) == 1
    assert {request.deadline_ns for _, request in link.asked} == {PATIENCE_NS}


def test_a_request_that_nobody_answers_is_given_up_at_its_deadline() -> None:
    answer, link = asked(lambda *_: None)
    assert answer is None
    assert len(link.asked) == PATIENCE_NS // ATTEMPT_NS


@pytest.mark.parametrize("after", [0, 1, 2])
def test_a_request_that_is_withdrawn_is_not_sent_again(after: int) -> None:
    clock, withdrawn = FakeClock(), threading.Event()

    def answering(_: EngagementRequest, attempt: int) -> None:
        if attempt == after:
            withdrawn.set()

    link = FakeLink(clock, answering)
    if after == 0:
        withdrawn.set()
    client = RequestClient(cast(Link, link), "lab", operator="anna", clock=clock)
    with pytest.raises(TransportError, match="a stop, or an end of the engagement, was asked for after it"):
        ask_engagement(client, EngagementAction.RESET, 5, withdrawn=withdrawn)
    assert len(link.asked) == after
    assert {request.seen_ns for _, request in link.asked} <= {5}


def test_the_deadline_is_in_the_remote_sites_clock() -> None:
    _, link = asked(lambda *_: reply("ok"), FakeRemoteClock(succeeds_at=1))
    assert link.asked[0][1].deadline_ns == PATIENCE_NS + OFFSET_NS


def test_nothing_is_asked_before_the_remote_sites_clock_is_known() -> None:
    answer, link = asked(lambda *_: reply("ok"), FakeRemoteClock(succeeds_at=3))
    assert answer == reply("ok")
    assert [at_ns for at_ns, _ in link.asked] == [2 * ATTEMPT_NS]
    silent, link = asked(lambda *_: reply("ok"), FakeRemoteClock(succeeds_at=99))
    assert silent is None
    assert link.asked == []


def test_a_stop_waits_for_no_clock_and_goes_to_a_queue_of_its_own() -> None:
    asked: list[tuple[object, object]] = []

    class Answering:
        def ask(
            self, procedure: Procedure[Any, Any], _cell: str, question: object, *, operator: str, timeout_s: float
        ) -> Reply | None:
            asked.append((procedure, question))
            return (
                reply("stopped") if (operator, timeout_s) == ("anna", REQUEST_TIMEOUT_S) and len(asked) == 3 else None
            )

    clock, unknown = FakeClock(), FakeRemoteClock(succeeds_at=99)
    client = RequestClient(cast(Link, Answering()), "lab", cast(RemoteClock, unknown), operator="anna", clock=clock)
    assert ask_engagement(client, EngagementAction.STOP) == reply("stopped")
    assert clock.time_ns == 2 * ATTEMPT_NS
    assert asked == [(STOP, StopRequest())] * 3


@pytest.mark.parametrize("took_ms", [0, 299, 300, 1000])
def test_attempts_are_apart_however_long_each_takes(took_ms: int) -> None:
    schedule = RequestSchedule(7, NS_PER_S, 0)
    schedule.sent(0)
    assert schedule.due_ns == ATTEMPT_NS
    schedule.sent(took_ms * NS_PER_MS)
    assert schedule.due_ns == min(took_ms * NS_PER_MS + ATTEMPT_NS, NS_PER_S)
    assert not schedule.is_over(NS_PER_S - 1)
    assert schedule.is_over(NS_PER_S)

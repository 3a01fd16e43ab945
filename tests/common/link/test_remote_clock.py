"""Measuring the clock never waits for the probe that finds out why nobody answers; what it finds is told later."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from common.errors import RefusedError, TransportError
from common.link.aside import Aside
from common.link.remote_clock import RemoteClock
from common.messages.requests import ClockAnswer
from lab.stage.waiting import until
from tests.common.link.secured_cell import CELL

ANSWER = ClockAnswer(received_ns=1, answered_ns=2)
WHY = "the other site refuses us"


class StuckLink:
    """A link whose other end is silent or answers, and whose probes last until they are let go."""

    def __init__(self) -> None:
        self.answers, self.refuses = False, False
        self.probes = self.ended = 0
        self.let_go = threading.Event()

    def ask(self, *_: object) -> ClockAnswer | None:
        return ANSWER if self.answers else None

    def check_connected(self) -> None:
        self.probes += 1
        assert self.let_go.wait(9.0)
        self.ended += 1
        if self.refuses:
            raise RefusedError(WHY)


@contextmanager
def silent(rounds: int) -> Iterator[tuple[StuckLink, RemoteClock]]:
    """A clock that has not been answered for so many rounds, of which each second one is doubted."""
    link = StuckLink()
    clock = RemoteClock(link, CELL, 2)  # type: ignore[arg-type]  # what it needs of a link
    for _ in range(rounds):
        assert clock.measure() is None
    try:
        yield link, clock
    finally:
        link.let_go.set()


def all_probed() -> bool:
    """Whether no probe lasts."""
    return all(thread.name != "probe" for thread in threading.enumerate())


def told(clock: RemoteClock) -> str:
    try:
        clock.measure()
    except RefusedError as error:
        return str(error)
    return ""


def test_rounds_go_on_while_a_probe_lasts_and_no_second_one_begins() -> None:
    with silent(10) as (link, clock):
        until(lambda: link.probes)
        assert clock.silent_rounds == 10
        link.answers = True
        assert clock.measure() is not None
        assert (link.probes, link.ended) == (1, 0)


def test_what_a_probe_found_is_told_by_a_later_round_and_once() -> None:
    with silent(2) as (link, clock):
        link.refuses = True
        link.let_go.set()
        until(lambda: told(clock) == WHY)


def test_a_probe_of_a_site_that_has_answered_meanwhile_does_not_matter() -> None:
    with silent(2) as (link, clock):
        link.refuses = link.answers = True
        assert clock.measure() is not None
        link.let_go.set()
        until(all_probed)
        assert link.ended == 1
        assert told(clock) == ""


def test_work_that_is_done_aside_ends_with_one_error_that_is_raised_once() -> None:
    aside, done = Aside("work"), threading.Event()

    def fail() -> None:
        done.set()
        raise TransportError(WHY)

    aside.start(fail)
    assert done.wait(9.0)

    def raised() -> bool:
        try:
            aside.check()
        except TransportError:
            return True
        return False

    until(raised)
    aside.check()

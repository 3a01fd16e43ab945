"""QUIC that is blocked where TLS comes through: found in time at both ends, at the start and later."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace

import pytest

from common.link.channels import CLOCK, TROUBLE
from common.link.endpoints import Endpoint
from common.link.probe import QuicBlockageDetector
from common.link.remote_clock import RemoteClock
from common.link.transport import open_link
from common.messages.requests import ClockAnswer, ClockQuestion, TroubleNoted
from farhand.loopback.site_process import free_ports
from lab.stage.waiting import until
from local_site.authority.lease_client import tell_by_tls
from tests.common.link.secured_cell import ANNA, CELL, running, secured
from tests.common.link.test_remote_clock import all_probed


def test_quic_counts_as_blocked_after_three_seconds_in_which_tls_answers_and_never_without() -> None:
    doubt = Doubt()
    assert doubt.at(100.0) is None
    assert doubt.at(102.9) is None
    assert "let UDP through to port 7447" in (doubt.at(103.1) or "")
    assert doubt.at(103.2, answers=False) is None
    assert doubt.at(104.0) is None
    assert doubt.at(110.0, was_up=True) is None
    assert Doubt("tls").at(200.0) is None


def test_over_a_long_way_quic_has_twenty_times_as_long_as_tls_took() -> None:
    doubt = Doubt()
    assert doubt.at(100.0, took_s=0.5) is None
    assert doubt.at(109.4, took_s=0.5) is None
    assert doubt.at(110.1, took_s=0.5) is not None


class Doubt:
    """A doubt about an endpoint, at times that are told."""

    def __init__(self, protocol: str = "quic") -> None:
        self._doubt, self._endpoint = QuicBlockageDetector(), Endpoint(protocol, "cell", 7447)

    def at(self, now_s: float, *, answers: bool = True, was_up: bool = False, took_s: float = 0.0) -> str | None:
        """The verdict once the endpoint has answered by TLS, or not, which took so long."""
        times = iter((now_s - took_s, now_s))
        return self._doubt.blocked(
            self._endpoint, was_up=was_up, speaks_tls=lambda _: answers, now_s=lambda: next(times)
        )


def test_the_first_silence_is_doubted_within_five_seconds_and_later_ones_seldom() -> None:
    checked: list[int] = []

    def clock_of(answers: list[ClockAnswer | None]) -> RemoteClock:
        link = SimpleNamespace(
            ask=lambda *_: answers.pop(0), check_connected=lambda: checked.append(clock.silent_rounds)
        )
        return RemoteClock(link, CELL, 25)  # type: ignore[arg-type]  # what it needs of a link

    clock = clock_of([None] * 30)
    for _ in range(30):
        clock.measure()
        until(all_probed)
    assert checked == [8, 17, 25]  # of five rounds a second
    checked.clear()
    clock = clock_of([ClockAnswer(received_ns=1, answered_ns=2), *[None] * 30])
    for _ in range(31):
        clock.measure()
        until(all_probed)
    assert checked == [25]


@pytest.mark.slow
def test_the_remote_site_is_told_by_tls_what_keeps_quic_from_it(pki: Path) -> None:
    with running(secured(pki, "remote"), "tls") as cell:
        endpoint = cell.endpoint.replace("tls/", "quic/")
        heard = cell.link.answer(TROUBLE, CELL, print, operator=ANNA)
        with (
            ThreadPoolExecutor(1) as pool,
            open_link(connect=(endpoint,), security=secured(pki, "operator.anna")) as link,
        ):
            done = pool.submit(tell_by_tls, link, CELL, ANNA, "UDP is blocked")
            found: list[str] = []

            def heard_it() -> bool:
                if (told := heard.take()) is not None:
                    found.append(told.question.reason)
                    told.reply(TroubleNoted())
                return bool(found)

            until(heard_it)
            assert done.result()
            assert found == ["UDP is blocked"]


def test_quic_that_is_cut_off_later_is_named_while_tls_answers(pki: Path) -> None:
    with ExitStack() as stack:
        with running(secured(pki, "remote"), "quic") as cell:
            link = stack.enter_context(open_link(connect=(cell.endpoint,), security=secured(pki, "operator.anna")))
            until(lambda: link.ask(CLOCK, CELL, ClockQuestion()))
            assert link.why_no_quic() == ""
        port = int(cell.endpoint.rpartition(":")[2])
        until(lambda: not link._session.info.links())
        assert link.why_no_quic() == ""
        stack.enter_context(running(secured(pki, "remote"), "tls", port))
        assert f"no longer by QUIC: let UDP through to port {port}" in link.why_no_quic()


def test_a_link_that_was_up_is_not_called_blocked_although_nothing_was_answered(pki: Path) -> None:
    port = free_ports(1)[0]
    with ExitStack() as stack:
        with open_link(listen=(f"quic/localhost:{port}",), security=secured(pki, "remote"), operators=("anna",)):
            link = stack.enter_context(
                open_link(connect=(f"quic/localhost:{port}",), security=secured(pki, "operator.anna"))
            )
            until(link._session.info.links)
            assert link.ask(CLOCK, CELL, ClockQuestion()) is None
        until(lambda: not link._session.info.links())
        stack.enter_context(running(secured(pki, "remote"), "tls", port))
        assert "no longer by QUIC" in link.why_no_quic()

"""A path's site asks for the cell more and more rarely, and ends with the endpoint that did not answer."""

from typing import Any

import pytest
import structlog

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_S, FakeClock
from common.errors import RefusedError, TransportError
from common.link.transport import Link
from common.process.service import StopFlag
from local_site.runtime.path_site import described_cell

ENDPOINT = "tcp/127.0.0.1:7447"


class SilentLink(Link):
    """A link at which nobody answers before the question of this number, if ever."""

    def __init__(self, clock: FakeClock, answers_at: int = 0, refusal: str = "", why: str = "") -> None:
        self._clock, self._answers_at, self._refusal, self._why = clock, answers_at, refusal, why
        self.asked_s: list[float] = []

    def ask(self, *_: Any, **_named: Any) -> Any:
        self.asked_s.append(self._clock.time_ns / NS_PER_S)
        return golden.DESCRIPTION if len(self.asked_s) == self._answers_at else None

    def check_connected(self) -> None:
        if self._refusal:
            raise RefusedError(self._refusal)

    def why_silent(self) -> str:
        return self._why


class Waiting(StopFlag):
    """Waits on a clock of the test; asked to stop at a time."""

    def __init__(self, clock: FakeClock, stop_s: float = 1e9) -> None:
        self._clock, self._stop_s = clock, stop_s

    def __call__(self) -> bool:
        return self._clock.time_ns >= self._stop_s * NS_PER_S

    def wait(self, timeout_s: float) -> bool:
        self._clock.advance_ms(1000 * timeout_s)
        return self()


@pytest.fixture
def clock() -> FakeClock:
    return FakeClock()


def test_without_a_site_it_ends_and_names_the_endpoint(clock: FakeClock) -> None:
    link = SilentLink(clock)
    told = f"no remote site of cell lab answers at {ENDPOINT}: start it there"
    with structlog.testing.capture_logs() as lines, pytest.raises(TransportError, match=told):
        described_cell(link, "lab", ENDPOINT, clock, Waiting(clock))
    assert link.asked_s == [0.0, 0.5, 1.5, 3.5, 7.5, 15.5, 23.5, 30.0]
    assert len(lines) == len(link.asked_s) - 1
    assert all(line["endpoint"] == ENDPOINT for line in lines)


@pytest.mark.parametrize(("refusal", "why", "told"), [("not yours", "", "not yours"), ("", "add the name", "add the")])
def test_why_it_does_not_answer_is_told_where_known(clock: FakeClock, refusal: str, why: str, told: str) -> None:
    with pytest.raises(TransportError, match=told):
        described_cell(SilentLink(clock, refusal=refusal, why=why), "lab", ENDPOINT, clock, Waiting(clock))


def test_a_site_that_comes_later_is_taken_and_a_stop_is_obeyed(clock: FakeClock) -> None:
    assert described_cell(SilentLink(clock, 4), "lab", ENDPOINT, clock, Waiting(clock)) is golden.DESCRIPTION
    soon = Waiting(clock, clock.time_ns / NS_PER_S + 1)
    assert described_cell(SilentLink(clock), "lab", ENDPOINT, clock, soon) is None

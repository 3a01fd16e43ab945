"""The local site passes on what its recorder tells, and to the recorder what may be asked of it."""

from collections.abc import Callable
from typing import Any

import msgspec
import pytest

import tests.common.messages.golden_examples as golden
from common.clock import NS_PER_S
from common.link.channels import RECORD_ORDER, RECORDER, RECORDING
from common.link.transport import Link
from common.messages.recording import RecordingNotice
from common.messages.requests import RecordAction, RecordRequest, Reply
from local_site.authority.lease_client import LeaseAndClock
from local_site.config import LocalConfig
from local_site.runtime.recorder_relay import RecorderRelay

IDLE = msgspec.structs.replace(golden.RECORDING, writing=False, on_request=True)
START = RecordRequest(id=7, deadline_ns=1, action=RecordAction.START)


class End:
    """One end of the link: what waits to be taken, and what was put."""

    def __init__(self) -> None:
        self.waiting: list[Any] = []
        self.put_messages: list[Any] = []

    def take(self) -> Any:
        return self.waiting.pop(0) if self.waiting else None

    def put(self, message: Any) -> None:
        self.put_messages.append(message)

    def poll(self, _now_ns: int, handle: Callable[[RecordRequest], Reply]) -> None:
        if self.waiting:
            self.put_messages.append(handle(self.waiting.pop(0)))


class Wires(Link):
    """A link with an end for each channel, and one for the requests."""

    def __init__(self) -> None:
        self.recorder, self.console, self.orders, self.asked = End(), End(), End(), End()
        self._ends = {RECORDER: self.recorder, RECORDING: self.console, RECORD_ORDER: self.orders}

    def latest(self, channel, *_, **_named):
        return self._ends[channel]

    def publisher(self, channel, *_, **_named):
        return self._ends[channel]

    def serve(self, *_, **_named):
        return self.asked


class Standing:
    """Holds this lease."""

    lease = 41

    def lease_and_clock(self, _now_ns: int) -> LeaseAndClock:
        return LeaseAndClock(self.lease)


@pytest.fixture
def wires() -> Wires:
    return Wires()


@pytest.fixture
def relay(wires: Wires) -> RecorderRelay:
    return RecorderRelay(LocalConfig(), wires, Standing())


def ask(relay: RecorderRelay, wires: Wires, now_ns: int) -> str:
    wires.asked.waiting.append(START)
    relay.poll(now_ns)
    return str(wires.asked.put_messages[-1].code)


def test_what_is_granted_reaches_the_recorder_and_what_it_tells_the_console(relay: RecorderRelay, wires: Wires) -> None:
    notice = RecordingNotice(state=IDLE)
    wires.recorder.waiting.append(notice)
    assert ask(relay, wires, NS_PER_S) == "record_asked"
    assert wires.console.put_messages == [notice]
    assert wires.orders.put_messages == [START]


def test_without_a_lease_or_a_recorder_that_lives_nothing_reaches_it(
    relay: RecorderRelay, wires: Wires, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert ask(relay, wires, 10 * NS_PER_S) == "no_recorder"
    wires.recorder.waiting.append(RecordingNotice(state=IDLE))
    with monkeypatch.context() as without:
        without.setattr(Standing, "lease", 0)
        assert ask(relay, wires, 10 * NS_PER_S) == "no_lease"
    assert ask(relay, wires, 13 * NS_PER_S) == "no_recorder"
    assert wires.orders.put_messages == []

"""Whatever a recorder writes into the site's memory, control goes on, and every page is told that one is there."""

import random
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from structlog.testing import capture_logs

from common.clock import NS_PER_S, FakeClock
from common.messages.codec import decode, encode
from common.messages.recording import RecordingNotice, RecordingState
from remote_site.recording.memory import RecordingMemory
from remote_site.recording.taps import UNREADABLE, ControlTap
from remote_site.shared_ring import HEAD, HEADER_BYTES, NUMBER, RESERVED, RingReader, SharedRing
from tests.common.recording.recorder_states import ASKED

SEEDS = range(300)
ENCODE = msgspec.msgpack.encode


class RecordedControl:
    """Control's tap, and what a recorder writes beside it."""

    def __init__(self, folder: Path) -> None:
        self.clock = FakeClock(NS_PER_S)
        self.memory = RecordingMemory.create(folder / "memory", self.clock.now_ns())
        self.tap = ControlTap(self.memory, self.clock)
        self.memory.beat(self.clock.now_ns())

    def told(self, *records: bytes) -> RecordingState | None:
        for data in records:
            self.memory.status.write(data)
        return self.tap.state(self.clock.now_ns())


@pytest.fixture
def control(tmp_path: Path) -> Iterator[RecordedControl]:
    made = RecordedControl(tmp_path)
    yield made
    made.memory.remove()
    made.memory.close()


def fields(**other: object) -> dict[str, Any]:
    return {**msgspec.to_builtins(ASKED), **other}


def test_a_recorder_of_the_next_release_writes_an_unknown_field_and_a_long_alarm(control):
    state = control.told(ENCODE(fields(cameras=("side", "front"), alarm="disk " * 200, lost=3)))
    assert state is not None
    assert (state.writing, state.lost) == (True, 3)
    assert state.alarm.startswith("disk disk")
    sent = encode(RecordingNotice(state=state))
    assert decode(sent, RecordingNotice, 10_000).state == state


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\xc1",
        ENCODE(None),
        ENCODE([1, 2]),
        ENCODE({}),
        ENCODE(fields(writing="yes")),
        ENCODE(fields(lost=-1)),
        ENCODE(fields(lost=2**64 - 1)),
        ENCODE(fields(lost=float("nan"))),
        ENCODE(fields(episode=1e300)),
        ENCODE(fields(outcome="perhaps")),
        ENCODE({name: value for name, value in fields().items() if name != "lost"}),
        ENCODE({1: 2}),
        b"\x91" * 15_000,
        b"\x81\xa5extra" + b"\x91" * 15_000,
        b"\x81\xa4task\xa2\xff\xfe",
    ],
)
def test_what_cannot_be_read_is_refused_and_said_once_and_counts_as_a_recording(control, data):
    with capture_logs() as lines:
        assert [control.told(data) for _ in range(5)] == [UNREADABLE] * 5
    assert [line["log_level"] for line in lines] == ["warning"]
    assert UNREADABLE.writing
    assert "farhand record" in UNREADABLE.alarm
    encode(RecordingNotice(state=UNREADABLE))
    assert control.told(ENCODE(ASKED)) == ASKED


def test_any_bytes_at_all_leave_control_a_state_that_it_can_send(control):
    valid = ENCODE(ASKED)
    for seed in SEEDS:
        chance = random.Random(seed)  # noqa: S311  # bytes to try, the same each time
        damaged = bytearray(valid if seed % 2 else chance.randbytes(chance.randrange(200)))
        for _ in range(chance.randrange(1, 4) if damaged else 0):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        state = control.told(bytes(damaged))
        assert state is not None
        encode(RecordingNotice(state=state))


def test_states_that_come_faster_than_ticks_do_not_keep_control(control):
    records = [ENCODE(fields(lost=k)) for k in range(200)]
    state = control.told(*records)
    for _ in range(200):
        state = control.tap.state(control.clock.now_ns())
    assert state is not None
    assert state.lost == 199


@pytest.mark.parametrize("content", ["zeros", "fillers", "noise"])
def test_a_ring_whose_head_is_nowhere_ends_the_look_soon(content):
    """In a ring of zeros every place holds an empty record, in one of fillers none does."""
    memory = memoryview(bytearray(HEADER_BYTES + 4096))
    reader = RingReader(SharedRing(memory), from_first=True)
    if content == "fillers":
        memory[HEADER_BYTES:] = struct.pack("<IIQ", 0xFFFFFFFF, 0, 0) * 256
    elif content == "noise":
        memory[HEADER_BYTES:] = random.Random(1).randbytes(4096)  # noqa: S311
    words = memory[:HEADER_BYTES].cast("Q")
    words[RESERVED], words[HEAD], words[NUMBER] = 0, 2**62, 2**40
    taken = [reader.take() for _ in range(20)]
    assert set(taken) <= {None, b""}

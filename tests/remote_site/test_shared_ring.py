"""A ring hands every record over once and whole, counts what a slow reader lost, and outlives its writer."""

import mmap
import multiprocessing
import os
import signal
import struct
from random import Random

import pytest

from remote_site.shared_ring import HEADER_BYTES, RingReader, SharedRing

FORK = multiprocessing.get_context("fork")


def ring(size: int) -> SharedRing:
    return SharedRing(memoryview(mmap.mmap(-1, HEADER_BYTES + size)))


def record(number: int, length: int) -> bytes:
    return struct.pack("<Q", number) + bytes([number % 251]) * length


def taken(reader: RingReader) -> list[bytes]:
    return list(iter(reader.take, None))


def test_records_of_any_length_come_once_and_in_order_over_many_rounds():
    shared, rng = ring(4096), Random(1)  # noqa: S311
    reader, numbers = RingReader(shared), iter(range(10**6))
    for _ in range(500):
        written = [record(next(numbers), rng.randrange(0, 300)) for _ in range(rng.randrange(0, 4))]
        for data in written:
            assert shared.write(data)
        assert taken(reader) == written
    assert reader.lost == 0


def test_a_reader_that_was_overtaken_counts_what_it_lost_and_goes_on():
    shared = ring(4096)
    reader = RingReader(shared)
    for number in range(1000):
        shared.write(record(number, 100))
    late = taken(reader)
    shared.write(record(1000, 100))
    assert taken(reader) == [record(1000, 100)]
    assert reader.lost + len(late) + 1 == 1001


def test_a_record_that_is_too_large_counts_as_lost():
    shared = ring(4096)
    reader = RingReader(shared)
    assert not shared.write(bytes(2000))
    assert shared.write(b"next")
    assert taken(reader) == [b"next"]
    assert reader.lost == 1


def test_a_reader_begins_with_what_comes_after_it():
    shared = ring(4096)
    shared.write(b"before")
    reader = RingReader(shared)
    shared.write(b"after")
    assert taken(reader) == [b"after"]
    assert reader.lost == 0


def test_a_changed_byte_is_noticed():
    memory = memoryview(mmap.mmap(-1, HEADER_BYTES + 4096))
    shared = SharedRing(memory)
    reader = RingReader(shared)
    shared.write(b"spoiled")
    memory[HEADER_BYTES + 18] ^= 1
    assert taken(reader) == []
    shared.write(b"whole")
    assert taken(reader) == [b"whole"]
    assert reader.lost == 1


@pytest.mark.parametrize("counter", range(3))
@pytest.mark.parametrize("value", [2**64 - 1, 2**64 - 8, 2**63, 13])
def test_whatever_a_reader_writes_to_the_counters_the_writer_goes_on(counter, value):
    """Control's cycle writes here; the memory is shared with a recorder, which may be damaged."""
    memory = memoryview(mmap.mmap(-1, HEADER_BYTES + 4096))
    shared = SharedRing(memory)
    for number in range(60):
        if number % 20 == 10:
            memory[8 * counter : 8 * counter + 8] = value.to_bytes(8, "little")
        assert shared.write(record(number, 40 * (number % 20)))
    assert not shared.write(bytes(4096))
    fresh = RingReader(shared)
    shared.write(b"after")
    assert taken(fresh) == [b"after"]


def hammer(shared: SharedRing) -> None:
    rng = Random(2)  # noqa: S311
    for number in range(10_000_000):
        shared.write(record(number, rng.randrange(0, 700)))


@pytest.fixture
def hammered():
    shared = ring(1 << 16)
    writer = FORK.Process(target=hammer, args=(shared,))
    reader = RingReader(shared)
    writer.start()
    while shared.count < 1000:
        pass
    yield shared, reader, writer
    writer.kill()
    writer.join(5)


def assert_whole(data: bytes) -> int:
    number = int.from_bytes(data[:8], "little")
    assert set(data[8:]) <= {number % 251}
    return number


def test_no_record_is_torn_or_uncounted_however_hard_it_is_written(hammered):
    _, reader, _ = hammered
    seen, last = 0, -1
    while seen < 500:
        data = reader.take()
        if data is not None:
            number = assert_whole(data)
            assert number > last
            seen, last = seen + 1, number
            assert seen + reader.lost == last + 1


def test_a_writer_killed_at_any_moment_leaves_whole_records(hammered):
    shared, reader, writer = hammered
    os.kill(writer.pid, signal.SIGKILL)
    writer.join(5)
    numbers = [assert_whole(data) for data in taken(reader)]
    assert shared.count - 1 <= reader.lost + len(numbers) <= shared.count

"""Shared records are whole however hard they are written, and survive the death of their writer."""

import multiprocessing
import os
import signal
from typing import Any

import numpy as np
import pytest

from common.errors import DriverError
from remote_site.shared_record import SharedRecord
from remote_site.simulation.memory import CellMemory, command_dtype

FORK = multiprocessing.get_context("fork")


def hammer(record: SharedRecord) -> None:
    command = np.zeros((), record.dtype)
    for seq in range(1, 10_000_000):
        command["seq"] = command["t_ns"] = seq
        command["q"] = command["dq"] = command["ddq"] = seq
        record.write(command)


@pytest.fixture
def hammered():
    record = SharedRecord(command_dtype(6))
    writer = FORK.Process(target=hammer, args=(record,))
    writer.start()
    while record.count < 100:
        pass
    yield record, writer
    writer.kill()
    writer.join(5)


def assert_whole(read: Any) -> int:
    seq = int(read["seq"])
    values = np.concatenate([read["q"], read["dq"], read["ddq"], [read["t_ns"]]])
    assert (values == seq).all()
    return seq


def test_no_reader_ever_sees_a_torn_record(hammered):
    record, _ = hammered
    last = 0
    for _ in range(20_000):
        seq = assert_whole(record.read())
        assert seq >= last
        last = seq
    assert last > 100


def test_a_writer_killed_at_any_moment_leaves_a_whole_record(hammered):
    record, writer = hammered
    os.kill(writer.pid, signal.SIGKILL)
    writer.join(5)
    assert assert_whole(record.read()) >= 100


def test_a_record_that_is_never_whole_is_an_error_not_a_hang():
    record = SharedRecord(command_dtype(6))
    record._memory[70:90] = bytes(20)
    record._memory[64 + record._slot_bytes + 10] ^= 0xFF
    with pytest.raises(DriverError, match="no complete record"):
        record.read()


def test_a_read_is_a_copy():
    record = SharedRecord(command_dtype(2))
    before = record.read()
    command = np.zeros((), record.dtype)
    command["seq"] = 7
    record.write(command)
    record.write(command)
    assert before["seq"] == 0
    assert record.read()["seq"] == 7


def test_the_cell_shares_records_for_any_number_of_joints():
    memory = CellMemory.create(7)
    assert memory.command.read()["q"].shape == (7,)
    assert memory.snapshot.read()["qpos"].shape == (7 + 2 + 7,)

"""Records that processes of the remote site share without waiting: one writer, any number of readers, never torn."""

import mmap
import zlib
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from common.errors import DriverError

COUNTER_BYTES = 64
READ_ATTEMPTS = 1000
BLOCK_VALUES = 7
FINGERS = 2

Record = NDArray[np.void]


class SharedRecord:
    """One record in anonymous memory that a fork inherits, and its forerunners in the other slots.

    The writer fills the slot that no reader is sent to, then turns the counter; a writer killed half way leaves the
    last whole record standing. A reader takes a slot only if the counter stood still meanwhile and the checksum agrees,
    which also holds on processors that reorder writes.
    """

    def __init__(self, dtype: np.dtype[np.void], slots: int = 2) -> None:
        self.dtype = dtype
        self._slots = slots
        self._slot_bytes = dtype.itemsize + 4
        self._memory = mmap.mmap(-1, COUNTER_BYTES + slots * self._slot_bytes)
        self._counter = memoryview(self._memory)[:8].cast("Q")
        self.write(np.zeros((), dtype=dtype))

    @property
    def count(self) -> int:
        """How often the record has been written."""
        return self._counter[0]

    def write(self, record: Record) -> None:
        """Publish a record of this dtype (0-d array); only one process may write."""
        self.write_bytes(record.tobytes())

    def write_bytes(self, data: bytes) -> None:
        """The same with the record's bytes."""
        count = self._counter[0] + 1
        start = self._start(count)
        self._memory[start : start + self._slot_bytes] = data + zlib.crc32(data).to_bytes(4, "little")
        self._counter[0] = count

    def read(self) -> Record:
        """A copy of the newest record (0-d array); DriverError when no whole one is found in bounded tries."""
        return np.frombuffer(self.read_bytes(), dtype=self.dtype).reshape(())

    def read_bytes(self) -> bytes:
        """The bytes of the newest record."""
        for _ in range(READ_ATTEMPTS):
            data = self._try_read()
            if data is not None:
                return data
        raise DriverError(f"shared memory: no whole record in {READ_ATTEMPTS} tries; restart the remote site")

    def at(self, count: int) -> bytes | None:
        """The bytes of the record written as the so-many-eth, None once another has taken its slot."""
        return self._slot(count, self._slots - 2)

    def _try_read(self) -> bytes | None:
        return self._slot(self._counter[0], 0)

    def _slot(self, count: int, behind: int) -> bytes | None:
        """The slot's content, if no more than `behind` records have been written since."""
        start = self._start(count)
        slot = self._memory[start : start + self._slot_bytes]
        if self._counter[0] - count > behind:
            return None
        data = slot[:-4]
        return data if zlib.crc32(data) == int.from_bytes(slot[-4:], "little") else None

    def _start(self, count: int) -> int:
        return COUNTER_BYTES + (count % self._slots) * self._slot_bytes


def setup_dtype(joints: int) -> np.dtype[np.void]:
    """What the driver demands: after how long a silence the controller stops, within which limits, how firm a grip."""
    return np.dtype(
        [
            ("timeout_ns", np.int64),
            ("acceleration", np.float64, (joints,)),
            ("jerk", np.float64, (joints,)),
            ("grip_force_n", np.float64),
        ]
    )


def command_dtype(joints: int) -> np.dtype[np.void]:
    """A setpoint: `activation` counts the driver's activations, and while `run` is false the arm stops and holds."""
    return np.dtype(
        [
            ("seq", np.uint64),
            ("t_ns", np.int64),
            ("activation", np.uint32),
            ("run", np.bool_),
            ("gripper_open", np.bool_),
            ("q", np.float64, (joints,)),
            ("dq", np.float64, (joints,)),
            ("ddq", np.float64, (joints,)),
        ]
    )


def reading_dtype(joints: int) -> np.dtype[np.void]:
    """What the robot controller measured at `t_ns`; `obeyed_ns` is when it took `obeyed_seq`, 0 before the first.

    `fault` is a `ControllerFault`; `resting` says that no motion is under way.
    """
    return np.dtype(
        [
            ("t_ns", np.int64),
            ("obeyed_seq", np.uint64),
            ("obeyed_ns", np.int64),
            ("activation", np.uint32),
            ("active", np.bool_),
            ("resting", np.bool_),
            ("fault", np.uint8),
            ("gripper_open", np.bool_),
            ("opening_m", np.float64),
            ("force_n", np.float64),
            ("q", np.float64, (joints,)),
            ("dq", np.float64, (joints,)),
        ]
    )


def snapshot_dtype(joints: int) -> np.dtype[np.void]:
    """The posture of the whole cell at `t_ns`, for rendering: joints, fingers, block."""
    return np.dtype([("t_ns", np.int64), ("qpos", np.float64, (joints + FINGERS + BLOCK_VALUES,))])


@dataclass(frozen=True, slots=True)
class CellMemory:
    """Everything the simulated cell shares with the driver and the video; made before the processes fork."""

    setup: SharedRecord
    command: SharedRecord
    reading: SharedRecord
    snapshot: SharedRecord

    @classmethod
    def create(cls, joints: int) -> Self:
        """Empty records for an arm of so many joints."""
        kinds = (setup_dtype, command_dtype, reading_dtype, snapshot_dtype)
        return cls(*(SharedRecord(kind(joints)) for kind in kinds))

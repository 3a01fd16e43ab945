"""The memory that the simulated cell shares with the driver and the video: setup, command, reading, snapshot."""

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from common.geometry import Array
from common.messages.robot import GripperCommand
from remote_site.shared_record import Record, SharedRecord

BLOCK_VALUES = 7  # position and quaternion
FINGERS = 2
GRIPPER_COMMANDS = (GripperCommand.KEEP, GripperCommand.OPEN, GripperCommand.CLOSED)


def setup_dtype(joints: int) -> np.dtype[np.void]:
    """Return the type of the driver's setup of the controller: its command time-out, its stop's limits, its grip force.

    The limits are of each joint, rad/s² and rad/s³.
    """
    return np.dtype(
        [
            ("timeout_ns", np.int64),
            ("acceleration", np.float64, (joints,)),
            ("jerk", np.float64, (joints,)),
            ("grip_force_n", np.float64),
        ]
    )


def command_dtype(joints: int) -> np.dtype[np.void]:
    """Return the type of a setpoint in rad, rad/s and rad/s²; while `run` is false the arm stops and holds.

    `activation` counts the driver's activations; `gripper` is an index of `GRIPPER_COMMANDS`.
    """
    return np.dtype(
        [
            ("seq", np.uint64),
            ("t_ns", np.int64),
            ("activation", np.uint32),
            ("run", np.bool_),
            ("gripper", np.uint8),
            ("q", np.float64, (joints,)),
            ("dq", np.float64, (joints,)),
            ("ddq", np.float64, (joints,)),
        ]
    )


class CellCommand(NamedTuple):
    """The fields of `command_dtype`, as the controller takes them."""

    seq: int
    t_ns: int
    activation: int
    run: bool
    gripper: int
    q: Array
    dq: Array
    ddq: Array

    @classmethod
    def of(cls, record: Record) -> Self:
        """Take the fields out of a record of `command_dtype`."""
        return cls._make(record.item())


def reading_dtype(joints: int) -> np.dtype[np.void]:
    """Return the type of a reading at `t_ns`; `obeyed_ns` is when the controller took `obeyed_seq`, 0 before the first.

    `fault` is a `ControllerFault`; `resting` is whether no motion is under way.
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
            ("opening_m", np.float64),
            ("force_n", np.float64),
            ("q", np.float64, (joints,)),
            ("dq", np.float64, (joints,)),
        ]
    )


def snapshot_dtype(joints: int) -> np.dtype[np.void]:
    """Return the type of the whole cell's posture at `t_ns`, for rendering: joints, fingers, block."""
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
        """Make empty records for an arm of this many joints."""
        kinds = (setup_dtype, command_dtype, reading_dtype, snapshot_dtype)
        return cls(*(SharedRecord(kind(joints)) for kind in kinds))

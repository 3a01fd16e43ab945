"""What this package needs of Farhand's wire protocol, version 17: three messages, as docs/wire-protocol.md has them."""

import struct
from typing import Any, NamedTuple

import msgpack

VERSION = 17
MOST_BYTES, MOST_ITEMS = 16384, 64
SESSION, SEQ, T_NS, STATE, CODE, REASON = range(6)
Q_COMMANDED, BASE_T_TOOL, GRIPPER, GRIPPER_NEXT, TARGET = 9, 10, 11, 13, 22  # of RobotState, by their order
STATES = "disengaged", "engaged", "holding", "fault"
OPENS_NEXT = 0  # of GRIPPER_NEXT: the gripper is closed, the next toggle opens it
JOINTS_OF_CELL = 4  # of Description


class WireError(ValueError):
    """What came is no message of this version; the text names the cure."""


class CellState(NamedTuple):
    """What the robot is commanded, `t_ns` by the remote site's clock.

    `q` is in rad by the cell's order of joints; `tool` is x, y, z in m and the quaternion x, y, z, w in the base's
    frame: the target while the arm follows, else where the tool is. `is_open` is what the gripper is commanded, None
    without one. `reason` explains the `state`.
    """

    t_ns: int
    state: str
    reason: str
    q: tuple[float, ...]
    tool: tuple[float, ...]
    is_open: bool | None


def question() -> bytes:
    """A question without fields: for the clock, or the description."""
    return bytes(msgpack.packb([VERSION]))


def cell_state(payload: bytes) -> CellState:
    """The state in a message of the key `farhand/CELL/state`."""
    fields = _fields(payload)
    if len(fields) <= TARGET:
        raise WireError(f"a state has {len(fields)} fields, too few: install the release of the cell")
    try:
        aim = fields[TARGET] if fields[TARGET] is not None else fields[BASE_T_TOOL]
        return CellState(
            int(fields[T_NS]),
            STATES[fields[STATE]],
            str(fields[REASON]),
            _singles(fields[Q_COMMANDED]),
            _singles(aim[0]) + _singles(aim[1]),
            None if fields[GRIPPER] is None else fields[GRIPPER_NEXT] != OPENS_NEXT,
        )
    except (TypeError, IndexError, struct.error) as error:
        raise WireError(f"a state cannot be read: {error}") from error


def clock_times(payload: bytes) -> tuple[int, int, int]:
    """When the remote site received a question for its clock, and when it answered: ns by its clock.

    And by how much its steady time was ahead of that clock then.
    """
    received_ns, answered_ns, ahead_ns = _fields(payload)
    return int(received_ns), int(answered_ns), int(ahead_ns)


def joint_names(payload: bytes) -> list[str]:
    """The names of the cell's joints, in their order, from its description."""
    return [str(joint[0]) for joint in _fields(payload)[JOINTS_OF_CELL]]


def _fields(payload: bytes) -> list[Any]:
    """The fields of a message behind its version."""
    if len(payload) > MOST_BYTES:
        raise WireError(f"a message of {len(payload)} bytes, at most {MOST_BYTES}")
    try:
        items = msgpack.unpackb(payload, max_array_len=MOST_ITEMS, max_map_len=MOST_ITEMS, max_bin_len=MOST_BYTES)
    except (ValueError, msgpack.UnpackException) as error:
        raise WireError(f"no message: {error}") from error
    if not isinstance(items, list) or not items or items[0] != VERSION:
        version = items[0] if isinstance(items, list) and items else "none"
        raise WireError(f"the cell speaks version {version}, this package {VERSION}: install the release of the cell")
    return items[1:]


def _singles(packed: bytes) -> tuple[float, ...]:
    """A vector of numbers with single precision."""
    return struct.unpack(f"<{len(packed) // 4}f", packed)

"""The conformance vectors of docs/c500c-vectors: frames as the driver builds and reads them, scenarios emulated."""

import pytest

from remote_site.drivers.c500c.protocol import (
    GRIPPER_COMMANDS,
    LARGEST_ANSWER,
    LARGEST_REQUEST,
    RAD,
    Activation,
    ControllerState,
    Fault,
    Flag,
    Kind,
    Parser,
    ProtocolFrame,
    Setpoint,
    _crc,
)
from tests.present import present
from tests.remote_site.drivers.c500c.vector_player import mistakes
from tests.remote_site.drivers.c500c.vectors import FrameVector, load_frames, load_scenarios

FRAMES = load_frames()
SCENARIOS = load_scenarios()
KINDS = {kind.name.lower(): kind for kind in Kind}
LARGEST = {"host": LARGEST_REQUEST, "controller": LARGEST_ANSWER}


def said(frame: FrameVector) -> Activation | Setpoint | ControllerState | None:
    """What the vector says, as the driver's own message; None for a frame without a payload."""
    joints = tuple(joint * RAD for joint in frame.joints_urad or ())
    match frame.kind:
        case "activate":
            return Activation(present(frame.count), joints, present(frame.period_ms))
        case "setpoint":
            gripper = GRIPPER_COMMANDS[present(frame.gripper)]
            return Setpoint(present(frame.count), joints, gripper, present(frame.force_percent))
        case "state":
            flags, fault = Flag(present(frame.flags)), Fault(present(frame.fault))
            queued, activation, begun, taken = (
                present(count) for count in (frame.queued, frame.activation, frame.begun, frame.taken)
            )
            opening_m = present(frame.opening_10um) * 1e-5
            return ControllerState(flags, fault, queued, activation, begun, taken, opening_m, joints)
    return None


@pytest.mark.parametrize("checksum", FRAMES.crc, ids=lambda checksum: checksum.crc)
def test_checksums_are_those_of_the_vectors(checksum):
    assert _crc(bytes.fromhex(checksum.bytes)) == bytes.fromhex(checksum.on_the_line)
    assert int.from_bytes(bytes.fromhex(checksum.on_the_line), "little") == int(checksum.crc, 16)


@pytest.mark.parametrize("frame", FRAMES.frame, ids=lambda frame: frame.hex[:30])
def test_frames_are_built_as_the_vectors_say(frame):
    message = said(frame)
    payload = message.payload if message is not None else b""
    assert ProtocolFrame(frame.sequence, KINDS[frame.kind], payload).encoded == bytes.fromhex(frame.hex)


@pytest.mark.parametrize("frame", FRAMES.frame, ids=lambda frame: frame.hex[:30])
def test_frames_are_read_as_the_vectors_say(frame):
    (found,) = Parser(LARGEST[frame.sender]).feed(bytes.fromhex(frame.hex))
    assert (found.sequence, found.kind) == (frame.sequence, KINDS[frame.kind])
    message = said(frame)
    if message is None:
        assert found.payload == b""
    else:
        assert type(message).parse(found.payload) == message


@pytest.mark.parametrize("damaged", FRAMES.damaged, ids=lambda damaged: damaged.says)
def test_damaged_bytes_hold_no_frame(damaged):
    assert all(Parser(largest).feed(bytes.fromhex(damaged.hex)) == [] for largest in LARGEST.values())


@pytest.mark.parametrize(("start", "scenario"), SCENARIOS, ids=[scenario.name for _, scenario in SCENARIOS])
def test_the_emulator_answers_as_the_vectors_say(start, scenario):
    assert list(mistakes(start, scenario)) == []
